"""The `@node` decorator: a plain function becomes a typed node; its schema is its signature and nothing else."""

import functools
import inspect
import re
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Generic, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints, overload

from pydantic import BaseModel

from graphtex import docstrings
from graphtex.context import QUIET, Context, Injected, generator
from graphtex.errors import DeclarationError, did_you_mean
from graphtex.kinds import TYPES, ArrayType, find_type
from graphtex.parameters import parameters_model, validate
from graphtex.sockets import Axes, Gap, ValueType, check_axes

P = ParamSpec("P")
R = TypeVar("R")

RESERVED = frozenset({"node", "graph", "each", "seed", "on_error"})  # words of a node entry in a graph file
_INJECTED = "write it keyword-only as `rng: Rng = 0` or `ctx: Context = QUIET`"
_NO_RESULT = (inspect.iscoroutinefunction, inspect.isgeneratorfunction, inspect.isasyncgenfunction)
_ORDINARY = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


@dataclass(frozen=True)
class Socket:
    """An input or an output of a node."""

    name: str
    type: ValueType
    optional: bool = False
    axes: tuple[str, ...] = ()
    doc: str = ""

    def __str__(self) -> str:
        return f"{self.type}{' (optional)' if self.optional else ''}"


@dataclass(frozen=True, eq=False, repr=False)
class Node(Generic[P, R]):
    """A function with its schema; calling it with plain arrays validates, runs and validates again."""

    function: Callable[P, R]
    name: str
    version: int
    inputs: Mapping[str, Socket]
    outputs: Mapping[str, Socket]
    parameters: type[BaseModel]
    injected: frozenset[str]
    result: type[tuple] | None

    def __post_init__(self) -> None:
        for name in ("__doc__", "__name__", "__qualname__", "__module__"):
            object.__setattr__(self, name, getattr(self.function, name))
        object.__setattr__(self, "__wrapped__", self.function)  # inspect.signature and help() look here

    def __repr__(self) -> str:
        return f"<node {self.name}, version {self.version}>"

    def __reduce__(self) -> str:
        return self.function.__qualname__  # by reference, as functions are: the name in their module

    @property
    def summary(self) -> str:
        """The docstring's first paragraph."""
        return docstrings.summary(self.function.__doc__)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Run on plain arrays; ValueError names the socket or parameter that does not fit."""
        try:
            bound = inspect.signature(self.function).bind(*args, **kwargs)
        except TypeError as error:
            raise TypeError(f"{self.function.__name__}() {error}{self._hint(len(args), kwargs)}") from None
        sockets = {name: bound.arguments[name] for name in self.inputs if name in bound.arguments}
        values = {k: v for k, v in bound.arguments.items() if k not in self.inputs and k not in self.injected}
        parameters, problems = validate(self.parameters, values)
        if parameters is None:
            raise ValueError("; ".join(f"{'.'.join(map(str, path))}: {text}" for path, text in problems))
        extra: dict[str, Any] = {}
        if "rng" in self.injected:
            extra["rng"] = generator(bound.arguments.get("rng", 0))
        if "ctx" in self.injected:
            extra["ctx"] = bound.arguments.get("ctx", QUIET)
        outputs = self.run(sockets, parameters, extra)
        return self.result(**outputs) if self.result else next(iter(outputs.values()))  # type: ignore[return-value]

    def _hint(self, positional: int, named: Mapping[str, Any]) -> str:
        """Return what would fit where a call does not: names that are known, and that parameters go by name."""
        signature = inspect.signature(self.function)
        unknown = [name for name in named if name not in signature.parameters]
        if unknown:
            return did_you_mean(unknown[0], signature.parameters, label="arguments")
        parameters = ", ".join(f"{name}=..." for name in self.parameters.model_fields)
        return f"; parameters go by name: {parameters}" if parameters and positional > len(self.inputs) else ""

    def run(self, sockets: Mapping[str, Any], parameters: BaseModel, injected: Mapping[str, Any]) -> dict[str, Any]:
        """Run on checked parameters; return the checked, read-only outputs by name."""
        checked: dict[str, Any] = {}
        for name, socket in self.inputs.items():
            value = sockets.get(name)
            if value is None:
                if not socket.optional:
                    raise ValueError(f"{name}: {self.name} needs {socket.type}, got nothing")
                continue
            checked[name] = socket.type.check(value, name)
        check_axes([(n, self.inputs[n].axes, v) for n, v in checked.items() if self.inputs[n].axes])
        values = {name: getattr(parameters, name) for name in self.parameters.model_fields}
        call: Callable[..., R] = self.function
        return self.check_outputs(call(**checked, **values, **injected))

    def check_outputs(self, result: Any) -> dict[str, Any]:
        """Return what the function returned by socket name, checked; DeclarationError if the node broke its word."""
        if self.result and (not isinstance(result, tuple) or len(result) != len(self.outputs)):
            raise DeclarationError(f"{self.name} returns {self.result.__name__}, but gave {type(result).__name__}")
        items = tuple(result) if self.result else (result,)
        try:
            outputs = {s.name: s.type.check(v, s.name) for s, v in zip(self.outputs.values(), items, strict=True)}
            check_axes([(n, self.outputs[n].axes, v) for n, v in outputs.items() if self.outputs[n].axes])
        except ValueError as error:
            raise DeclarationError(f"{self.name} broke its own output's type: {error}") from error
        return outputs


@overload
def node(function: Callable[P, R]) -> Node[P, R]: ...
@overload
def node(*, version: int = 1, name: str | None = None) -> Callable[[Callable[P, R]], Node[P, R]]: ...
def node(function: Callable[P, R] | None = None, *, version: int = 1, name: str | None = None) -> Any:
    """Make a node of a module-level function.

    Positional arguments are sockets, keyword-only ones parameters; `rng` and `ctx` are injected.

    Parameters
    ----------
    version
        Raise it when the results change in a way that the code digest cannot see.
    name
        The name in graph files; without it the function's name in CamelCase.

    Raises
    ------
    DeclarationError
        If the function is a lambda or closure, or an annotation is missing or no known type.
    """
    if function is None:
        return functools.partial(_declare, version=version, name=name)
    return _declare(function, version=version, name=name)


def camel_case(name: str) -> str:
    """Return a function's name as a node's name.

    >>> camel_case("graph_cut_montage")
    'GraphCutMontage'
    """
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def require_plain_function(function: Any, what: str) -> str:
    """Return the function's name; DeclarationError unless it is an ordinary function at module level."""
    if not isinstance(function, types.FunctionType):
        raise DeclarationError(f"a {what} is made from a plain function, got {type(function).__name__}")
    if function.__name__ == "<lambda>" or "<locals>" in function.__qualname__ or "." in function.__qualname__:
        raise DeclarationError(
            f"{function.__qualname__}: a {what} is a module-level function, not a lambda, method or closure"
        )
    if function.__closure__ is not None:  # a wrapper made by another decorator has borrowed the function's name
        raise DeclarationError(f"{function.__name__}: a {what} is no closure; no decorator stands below @{what}")
    if any(test(function) for test in _NO_RESULT):
        raise DeclarationError(f"{function.__name__}: a {what} returns its result; it is no generator or coroutine")
    return function.__name__


def _declare(function: Callable[P, R], *, version: int, name: str | None) -> Node[P, R]:
    own = require_plain_function(function, "node")
    name = name or camel_case(own)
    if not re.fullmatch(r"[A-Z][A-Za-z0-9]*", name):
        raise DeclarationError(f"{own}: a node's name is CamelCase letters and digits, got {name!r}")
    if type(version) is not int or version < 1:
        raise DeclarationError(f"{own}: a version counts from 1, got {version}")
    try:
        hints = get_type_hints(function, include_extras=True)
    except NameError as error:
        raise DeclarationError(f"{own}: an annotation cannot be read: {error}") from error
    texts = docstrings.section(function.__doc__, "Parameters")
    inputs: dict[str, Socket] = {}
    keywords, injected = [], set()
    for parameter in inspect.signature(function).parameters.values():
        where = f"{own}({parameter.name})"
        if parameter.kind in (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD):
            raise DeclarationError(f"{where}: a node has no *args or **kwargs; a list socket is list[Image]")
        if parameter.name not in hints:
            raise DeclarationError(f"{where}: an annotation is required")
        if parameter.name in RESERVED:
            raise DeclarationError(
                f"{where}: the name is reserved in graph files; reserved: {', '.join(sorted(RESERVED))}"
            )
        if _is_injected(parameter, hints[parameter.name], where):
            injected.add(parameter.name)
        elif parameter.kind in _ORDINARY:
            inputs[parameter.name] = _input(parameter, hints[parameter.name], where, texts.get(parameter.name, ""))
        elif find_type(hints[parameter.name]) is not None:
            raise DeclarationError(
                f"{where}: data flows through positional arguments; a keyword-only one is a parameter"
            )
        elif parameter.name in ("rng", "ctx"):
            raise DeclarationError(f"{where}: {_INJECTED}")
        else:
            keywords.append(parameter)
    outputs, result = _outputs(own, hints.get("return"), docstrings.section(function.__doc__, "Returns"))
    model = parameters_model(name, keywords, hints)
    return Node(function, name, version, inputs, outputs, model, frozenset(injected), result)


def _is_injected(parameter: inspect.Parameter, hint: Any, where: str) -> bool:
    extras = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    wanted = next((extra.name for extra in extras if isinstance(extra, Injected)), "ctx" if hint is Context else None)
    if wanted is None:
        return False
    if (
        parameter.name != wanted
        or parameter.kind is not inspect.Parameter.KEYWORD_ONLY
        or parameter.default is parameter.empty
    ):
        raise DeclarationError(f"{where}: {_INJECTED}")
    return True


def _input(parameter: inspect.Parameter, hint: Any, where: str, doc: str) -> Socket:
    optional, inner = _split_optional(hint)
    kind, axes = _value_type(inner, where)
    if optional != (parameter.default is None) or (not optional and parameter.default is not parameter.empty):
        raise DeclarationError(
            f"{where}: an optional socket is written `Mask | None = None`; a socket has no other default"
        )
    return Socket(parameter.name, kind, optional, axes, doc)


def _outputs(owner: str, hint: Any, texts: Mapping[str, str]) -> tuple[dict[str, Socket], type[tuple] | None]:
    if hint is None:
        raise DeclarationError(f"{owner}: the result's annotation is required")
    if isinstance(hint, type) and issubclass(hint, tuple) and hasattr(hint, "_fields") and find_type(hint) is None:
        outputs = {}
        for key, inner in get_type_hints(hint, include_extras=True).items():
            kind, axes = _value_type(inner, f"{owner} -> {hint.__name__}.{key}")
            outputs[key] = Socket(key, kind, False, axes, texts.get(key, ""))
        if not outputs:
            raise DeclarationError(f"{owner} -> {hint.__name__}: a node has at least one output")
        if any(socket.type.gaps for socket in outputs.values()):
            raise DeclarationError(f"{owner}: gaps stand for failed cells; a node takes them and gives none")
        return outputs, hint
    kind, axes = _value_type(hint, f"{owner} -> result")
    return {"result": Socket("result", kind, False, axes, " ".join(texts.values()))}, None


def _split_optional(hint: Any) -> tuple[bool, Any]:
    if get_origin(hint) in (Union, types.UnionType):
        rest = tuple(arg for arg in get_args(hint) if arg is not type(None))
        if len(rest) == 1 and len(rest) < len(get_args(hint)):
            return True, rest[0]
    return False, hint


def _value_type(hint: Any, where: str) -> tuple[ValueType, tuple[str, ...]]:
    outer, axes = _split_axes(hint)
    many = get_origin(outer) is list
    inner, gaps = (get_args(outer)[0] if many else outer), False
    if many and get_origin(inner) in (Union, types.UnionType):
        rest = [arg for arg in get_args(inner) if arg is not Gap]
        gaps = len(rest) < len(get_args(inner))
        inner = rest[0] if len(rest) == 1 else inner
    if many and not axes:
        axes = _split_axes(inner)[1]
    base = find_type(inner)
    if base is None:
        got = getattr(inner, "__name__", str(inner))
        raise DeclarationError(f"{where}: {got} is no socket type{did_you_mean(got, TYPES, label='socket types')}")
    rank = len(base.axes) if isinstance(base, ArrayType) else 0
    if axes and len(axes) != rank:
        raise DeclarationError(f"{where}: {base.name} has {rank} axes, Axes names {len(axes)}: {' '.join(axes)}")
    return ValueType(base, many, gaps), axes


def _split_axes(hint: Any) -> tuple[Any, tuple[str, ...]]:
    """Return an annotation, of a list without what annotates the list, and the names of axes that it gives."""
    if get_origin(hint) is not Annotated:
        return hint, ()
    inner, *extras = get_args(hint)
    axes = next((extra.split() for extra in extras if isinstance(extra, Axes)), ())
    return (inner if get_origin(inner) is list else hint), axes
