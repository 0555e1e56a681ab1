"""Writes models as STEP, IGES and BREP files by OpenCascade; with importer/ the only part that knows it.

Importing this package does not import OCP: files are written in a child process.
"""

from .write import Schema, Via, Written, write

__all__ = ["Schema", "Via", "Written", "write"]
