"""How long an impact takes on this machine, and with what error."""
