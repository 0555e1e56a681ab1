"""Pictures of whole libraries: finds files, draws each in isolation, remembers what became of it."""
