"""`Progress` and `silent` under the name that `belvedere.studio.walkthrough` asks for."""

from belvedere.ground.progress import Progress, silent

__all__ = ["Progress", "silent"]
