"""Pictures of whole libraries: finds files, draws each in isolation, remembers what became of it.

from trimray.batch import Settings, run
summary = run(["library"], "pictures", Settings(size=(512, 512)))
"""

from .record import Item, Outcome, Settings
from .run import Listener, Summary, run

__all__ = ["Item", "Listener", "Outcome", "Settings", "Summary", "run"]
