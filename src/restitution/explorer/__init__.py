"""The explorer: a page in the browser on which every input is a slider and every picture follows."""
