"""The plugin contract, and the registry that finds extractors by name.

A plugin offers a *factory* under the entry-point group `laserfeatures.extractors`: a callable that
takes keyword parameters and returns a *detector*, itself a callable from `LaserScan` to
`LineSegments`, or to `PointFeatures` if it finds corners without lines. A frozen dataclass with a
``__call__`` is both at once. A factory may have

``presets``
    a mapping from a name to another factory, chosen by ``get_extractor(..., preset=name)``;
``stages``
    a mapping from "segment_filter" or "intersections" to the parameters that this detector wants
    where they differ from the stage's own defaults.
"""

import difflib
import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from laserfeatures.errors import PluginError, UnknownExtractorError
from laserfeatures.optional import system_library

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

    from laserfeatures.pipeline import Detector, Pipeline

ENTRY_POINT_GROUP = "laserfeatures.extractors"
OWN_DISTRIBUTION = "laserfeatures"


Factory = Callable[..., "Detector"]

_registered: dict[str, Factory] = {}


def list_extractors() -> tuple[str, ...]:
    """Return the names of all extractors, sorted; no plugin is imported.

    Examples
    --------
    >>> "direct_hough" in list_extractors()
    True
    """
    return tuple(sorted({*_registered, *_entry_points().names}))


def register_extractor(name: str, factory: Factory, *, replace: bool = False) -> None:
    """Offer an extractor under `name` in this process.

    Parameters
    ----------
    name : str
        The name to find it by.
    factory : callable
        Takes keyword parameters, returns a detector: a callable from `LaserScan` to `LineSegments`
        or `PointFeatures`.
    replace : bool
        Whether `name` may be taken already.

    Raises
    ------
    ValueError
        If `name` is taken and `replace` is false, or is no identifier.
    TypeError
        If `factory` cannot be called.
    """
    if not name.isidentifier():
        raise ValueError(f"an extractor's name must be a Python identifier, got {name!r}")
    if not callable(factory):
        raise TypeError(f"the factory of {name!r} must be callable, got {factory!r}")
    if not replace and name in list_extractors():
        raise ValueError(f"extractor {name!r} exists already; pass replace=True to replace it")
    _registered[name] = factory


def find_factory(name: str, preset: str | None = None) -> Factory:
    """Return the factory registered as `name`, or its variant `preset`.

    Raises
    ------
    UnknownExtractorError
        If there is no such extractor; the message names the near ones.
    PluginError
        If its plugin cannot be imported.
    ValueError
        If it has no such preset.
    """
    factory = _registered.get(name) or _load(_find_entry_point(name))
    if preset is None:
        return factory
    presets: Mapping[str, Factory] = getattr(factory, "presets", {})
    if preset not in presets:
        raise ValueError(
            f"{name} has no preset {preset!r}; " + (near_names(preset, presets) or "it has none")
        )
    return presets[preset]


def get_extractor(name: str, *, preset: str | None = None, **parameters: Any) -> "Pipeline":
    """Return the extractor `name`: a callable from `LaserScan` to `Features`.

    Parameters
    ----------
    name : str
        One of `list_extractors()`.
    preset : str, optional
        A variant that the extractor offers by name, such as "paper" of direct_hough.
    **parameters
        Parameters of the detector, and ``segment_filter=SegmentFilter(...)`` and
        ``intersections=Intersections(...)`` for the shared stages.

    Raises
    ------
    UnknownExtractorError
        If there is no such extractor; the message names the near ones.
    PluginError
        If its plugin cannot be imported, or ends the program instead of making a detector.
    TypeError
        If it has no such parameter; the message names the near ones.
    ValueError
        If a parameter's value or the preset makes no sense.

    Examples
    --------
    >>> extractor = get_extractor("direct_hough", theta_step=0.02)
    >>> extractor.detector.theta_step
    0.02
    """
    # Imported here: the stages bring numba, which listing names does not need.
    from laserfeatures.pipeline import Pipeline  # noqa: PLC0415

    factory = find_factory(name, preset)
    stages: Mapping[str, Mapping[str, Any]] = getattr(factory, "stages", {})
    chosen = {stage: parameters.pop(stage, None) for stage in Pipeline.STAGES}
    for stage, kind in Pipeline.STAGES.items():
        if chosen[stage] is None:
            chosen[stage] = kind(**stages.get(stage, {}))
    _check_names(name, factory, parameters, Pipeline.STAGES)
    try:
        detector = factory(**parameters)
    except SystemExit as error:
        raise PluginError(f"extractor {name!r} cannot be made: SystemExit: {error}") from error
    return Pipeline(name=name, detector=detector, **chosen)


def near_names(name: str, names: Iterable[str]) -> str:
    """Say which of `names` may have been meant by `name`, or list them all."""
    names = sorted(names)
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.6)
    if near:
        return "did you mean " + " or ".join(repr(n) for n in near) + "?"
    return "there are: " + ", ".join(names) if names else ""


def _entry_points() -> "EntryPoints":
    # Imported here: it takes a fifth of the time that importing all of laserfeatures does.
    from importlib.metadata import entry_points  # noqa: PLC0415

    return entry_points(group=ENTRY_POINT_GROUP)


def _find_entry_point(name: str) -> "EntryPoint":
    found = tuple(_entry_points().select(name=name))
    if not found:
        raise UnknownExtractorError(
            f"no extractor is named {name!r}; {near_names(name, list_extractors())}"
        )
    own = [entry for entry in found if _distribution(entry) == OWN_DISTRIBUTION]
    if own:
        return own[0]  # somebody else's plugin cannot take the place of a built-in extractor
    if len({entry.value for entry in found}) > 1:
        offers = " and ".join(sorted(f"{_distribution(e)} ({e.value})" for e in found))
        raise PluginError(f"extractor {name!r} is offered by several packages: {offers}")
    return found[0]


def _distribution(entry: "EntryPoint") -> str:
    return entry.dist.name if entry.dist else "an unknown package"


def _load(entry: "EntryPoint") -> Factory:
    try:
        factory = entry.load()
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # also sys.exit(), or what skips a module in some test runner
        raise PluginError(
            f"extractor {entry.name!r} of {_distribution(entry)} cannot be loaded from "
            f"{entry.value!r}: {system_library(error) or f'{type(error).__name__}: {error}'}"
        ) from error
    if not callable(factory):
        raise PluginError(
            f"extractor {entry.name!r} of {_distribution(entry)}: {entry.value!r} must be "
            f"callable, got {type(factory).__name__}"
        )
    return factory  # type: ignore[no-any-return]


def _check_names(
    name: str, factory: Factory, parameters: Mapping[str, Any], stages: Iterable[str]
) -> None:
    signature = inspect.signature(factory).parameters
    if any(p.kind is p.VAR_KEYWORD for p in signature.values()):
        return
    for parameter in parameters:
        if parameter not in signature:
            known = [*signature, *stages]
            raise TypeError(
                f"{name} has no parameter {parameter!r}; {near_names(parameter, known)}"
            )
