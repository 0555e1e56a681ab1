"""What must be shown: checks of exactness against judges, small in the tests, in full by scripts/verify."""
