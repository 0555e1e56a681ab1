"""Thumbnails in file managers: the thumbnailer, its registration, and the freedesktop cache."""
