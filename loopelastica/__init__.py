"""Elastic-rod folding of nucleic-acid hairpin loops.

Public names are resolved when first used, so that importing the package costs nothing.
"""

import importlib
from typing import TYPE_CHECKING, Any

from loopelastica._version import __version__

_PUBLIC = {
    "Clamping": "rod.clamping",
    "RestShape": "rod.rest_shape",
    "Equilibrium": "rod.equilibrium",
    "Status": "rod.kernels.records",
    "Equilibria": "rod.equilibria",
    "equilibria": "rod.equilibria",
    "barriers": "rod.barriers",
    "Barriers": "rod.barriers",
    "Barrier": "rod.barriers",
    "morse_count": "rod.morse",
    "ways_down": "rod.descent",
    "PhysicalParameters": "rod.parameters",
    "continue_clamping": "rod.continuation",
    "twist_end": "rod.continuation",
    "solve": "rod.solve",
    "solve_batch": "rod.batch",
    "Batch": "rod.batch",
    "find_hairpins": "molecule.hairpins",
    "Hairpin": "molecule.hairpins",
    "Hairpins": "molecule.hairpins",
    "fold": "folding.fold",
    "Folds": "folding.folds",
    "LoopFold": "folding.result",
    "scan": "folding.scan",
    "LoopScan": "folding.scan",
    "LoopElastica": "folding.trajectory",
    "Candidate": "folding.rank",
    "Library": "folding.library",
    "load_library": "folding.library_file",
    "build_library": "batch.shapes",
    "build_atoms": "atoms.model",
    "AtomModel": "atoms.model",
    "build": "atoms.build",
    "HairpinModel": "atoms.build",
    "fill": "filling.fill",
    "Filling": "filling.result",
    "FilledStrand": "filling.result",
    "nanostructure": "nanostructures.nanostructure",
    "Nanostructure": "nanostructures.nanostructure",
    "restraints": "simulation",
    "to_dataframe": "report.dataframe",
    "write_report": "report.page.write",
    "LoopelasticaError": "errors",
    "StructureError": "errors",
    "MissingDependencyError": "errors",
}

__all__ = ["__version__", *_PUBLIC]

if TYPE_CHECKING:
    from loopelastica.atoms.build import HairpinModel as HairpinModel
    from loopelastica.atoms.build import build as build
    from loopelastica.atoms.model import AtomModel as AtomModel
    from loopelastica.atoms.model import build_atoms as build_atoms
    from loopelastica.batch.shapes import build_library as build_library
    from loopelastica.errors import LoopelasticaError as LoopelasticaError
    from loopelastica.errors import MissingDependencyError as MissingDependencyError
    from loopelastica.errors import StructureError as StructureError
    from loopelastica.filling.fill import fill as fill
    from loopelastica.filling.result import FilledStrand as FilledStrand
    from loopelastica.filling.result import Filling as Filling
    from loopelastica.folding.fold import fold as fold
    from loopelastica.folding.folds import Folds as Folds
    from loopelastica.folding.library import Library as Library
    from loopelastica.folding.library_file import load_library as load_library
    from loopelastica.folding.rank import Candidate as Candidate
    from loopelastica.folding.result import LoopFold as LoopFold
    from loopelastica.folding.scan import LoopScan as LoopScan
    from loopelastica.folding.scan import scan as scan
    from loopelastica.folding.trajectory import LoopElastica as LoopElastica
    from loopelastica.molecule.hairpins import Hairpin as Hairpin
    from loopelastica.molecule.hairpins import Hairpins as Hairpins
    from loopelastica.molecule.hairpins import find_hairpins as find_hairpins
    from loopelastica.nanostructures.nanostructure import Nanostructure as Nanostructure
    from loopelastica.nanostructures.nanostructure import nanostructure as nanostructure
    from loopelastica.report.dataframe import to_dataframe as to_dataframe
    from loopelastica.report.page.write import write_report as write_report
    from loopelastica.rod.barriers import Barrier as Barrier
    from loopelastica.rod.barriers import Barriers as Barriers
    from loopelastica.rod.barriers import barriers as barriers
    from loopelastica.rod.batch import Batch as Batch
    from loopelastica.rod.batch import solve_batch as solve_batch
    from loopelastica.rod.clamping import Clamping as Clamping
    from loopelastica.rod.continuation import continue_clamping as continue_clamping
    from loopelastica.rod.continuation import twist_end as twist_end
    from loopelastica.rod.descent import ways_down as ways_down
    from loopelastica.rod.equilibria import Equilibria as Equilibria
    from loopelastica.rod.equilibria import equilibria as equilibria
    from loopelastica.rod.equilibrium import Equilibrium as Equilibrium
    from loopelastica.rod.kernels.records import Status as Status
    from loopelastica.rod.morse import morse_count as morse_count
    from loopelastica.rod.parameters import PhysicalParameters as PhysicalParameters
    from loopelastica.rod.rest_shape import RestShape as RestShape
    from loopelastica.rod.solve import solve as solve
    from loopelastica.simulation import restraints as restraints


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'loopelastica' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"loopelastica.{_PUBLIC[name]}"), name)
    # set once: also keeps the function `fold` in front of the module of that name
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
