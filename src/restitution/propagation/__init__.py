"""Error bars: derivatives of outputs by inputs, and the uncertainty of inputs through them."""
