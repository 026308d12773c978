"""The version, in one place: the package, its files and its reports all say this."""

__version__ = "0.1.0"
