"""The version, where it costs nothing to read; pyproject.toml says the same."""

__version__ = "0.1.0"
