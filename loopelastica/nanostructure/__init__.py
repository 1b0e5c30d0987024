"""Single strands of DNA nanostructures: between helices of a design, in the units of oxDNA."""

import sys
from types import ModuleType
from typing import Any


class _Room(ModuleType):
    """A package that has the name of its public function, and works as that too.

    When it is imported Python puts it in the place of ``loopelastica.nanostructure``, whether the
    function was there or not.
    """

    def __call__(self, path: Any, /, **options: Any) -> Any:
        from loopelastica.nanostructure.nanostructure import nanostructure

        return nanostructure(path, **options)


sys.modules[__name__].__class__ = _Room
