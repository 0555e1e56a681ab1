"""The command ``trimray``. Uses the public package only."""
