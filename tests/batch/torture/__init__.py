"""A library of a thousand hostile files, made from a seed, and the judge of a batch that was run on it."""
