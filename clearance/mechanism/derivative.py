"""Exact derivatives of plain functions: forward differentiation of their source.

A law stays the plain function its author wrote. `jacobian_text` reads that source and writes a second plain function
that returns the values and their derivatives with respect to the leading arguments, statement by statement, so loops,
branches and helper functions are allowed. It reads arithmetic, `math`, abs, max, min, if, for, while.
"""

import ast
import itertools
import math

Tangents = dict[int, str]

#: derivative of math.<name>(x), with {x} the argument and {y} the value
_UNARY = {
    "sqrt": "0.5 / {y}", "exp": "{y}", "log": "1.0 / {x}", "sin": "math.cos({x})", "cos": "-math.sin({x})",
    "tan": "1.0 + {y} * {y}", "tanh": "1.0 - {y} * {y}", "sinh": "math.cosh({x})", "cosh": "math.sinh({x})",
    "asin": "1.0 / math.sqrt(1.0 - {x} * {x})", "acos": "-1.0 / math.sqrt(1.0 - {x} * {x})",
    "atan": "1.0 / (1.0 + {x} * {x})", "fabs": "math.copysign(1.0, {x})", "log1p": "1.0 / (1.0 + {x})",
    "expm1": "{y} + 1.0", "asinh": "1.0 / math.sqrt({x} * {x} + 1.0)", "atanh": "1.0 / (1.0 - {x} * {x})",
    "erf": "1.1283791670955126 * math.exp(-{x} * {x})", "erfc": "-1.1283791670955126 * math.exp(-{x} * {x})",
}  # fmt: skip
_FLAT = {"floor", "ceil", "trunc", "int"}


def jacobian_text(library, entry, active: tuple[int, ...], name: str) -> str:
    """Source of the function `name` that returns (values..., d value_0 / d arg_i..., d value_1 / d arg_i..., ...).

    library: where the functions that `entry` calls are found and their derivatives are put; active: positions of the
    arguments to differentiate by. Raises ValueError naming the law for what it cannot read.
    """
    return _Differentiator(library, entry, active).text(name)


class _Differentiator:
    def __init__(self, library, entry, active: tuple[int, ...]):
        self.library, self.active, self.name, self.tree = library, active, entry.name, entry.tree
        self.arguments = [a.arg for a in self.tree.args.args]
        self.reach: dict[str, set[int]] = {self.arguments[p]: {i} for i, p in enumerate(active)}
        names = {n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name)} | set(self.arguments)
        self.mark = next(k for k in itertools.count() if not any(n.startswith((f"d{k}_", f"w{k}_")) for n in names))

    def text(self, name: str) -> str:
        """Repeat until the set of variables that depend on each seed stops growing, then write the function."""
        while True:
            before = {k: set(v) for k, v in self.reach.items()}
            self.lines: list[str] = []
            self.indent, self.count = 1, itertools.count()
            for i, p in enumerate(self.active):
                argument = self.arguments[p]
                for j in sorted(self.reach[argument]):
                    self._emit(f"{self._d(j, argument)} = {'1.0' if i == j else '0.0'}")
            self._block(self.tree.body)
            if before == self.reach:
                return "\n".join([f"def {name}({ast.unparse(self.tree.args)}):", *self.lines])

    # --- statements
    def _emit(self, line: str) -> None:
        self.lines.append("    " * self.indent + line)

    def _block(self, body) -> None:
        for statement in body:
            handler = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if handler is None:
                raise self._unreadable(statement)
            handler(statement)

    def _nested(self, header: str, body) -> None:
        self._emit(header)
        self.indent += 1
        self._block(body)
        self.indent -= 1

    def _unreadable(self, node) -> ValueError:
        return ValueError(f"law {self.name}: cannot differentiate {ast.unparse(node)!r}")

    def _pass(self, node):
        self._emit("pass")

    def _expr(self, node):
        if not isinstance(node.value, ast.Constant):
            raise self._unreadable(node)

    def _if(self, node):
        self._nested(f"if {ast.unparse(node.test)}:", node.body)
        if node.orelse:
            self._nested("else:", node.orelse)

    def _while(self, node):
        self._nested(f"while {ast.unparse(node.test)}:", node.body)

    def _for(self, node):
        if node.orelse or not isinstance(node.target, ast.Name):
            raise self._unreadable(node)
        self._emit(f"for {node.target.id} in {ast.unparse(node.iter)}:")
        self.indent += 1
        for i in sorted(self.reach.get(node.target.id, ())):
            self._emit(f"{self._d(i, node.target.id)} = 0.0")
        self._block(node.body)
        self.indent -= 1

    def _break(self, node):
        self._emit("break")

    def _continue(self, node):
        self._emit("continue")

    def _augassign(self, node):
        value = ast.BinOp(ast.Name(node.target.id, ast.Load()), node.op, node.value)
        self._bind(node.target, *self._value(value))

    def _annassign(self, node):
        self._bind(node.target, *self._value(node.value))

    def _assign(self, node):
        if len(node.targets) > 1 and all(isinstance(t, ast.Name) for t in node.targets):
            value, tangents = self._hold(*self._value(node.value))
            for target in node.targets:
                self._bind(target, value, tangents)
            return
        target = node.targets[0]
        if isinstance(target, ast.Name):
            self._bind(target, *self._value(node.value))
            return
        if not isinstance(target, ast.Tuple):
            raise self._unreadable(node)
        if isinstance(node.value, ast.Tuple):
            values = [self._value(v) for v in node.value.elts]
        else:
            values = self._call_many(node.value)
        # two rounds, so that a swap such as a, b = b, a reads the old values
        held = [self._hold(v, d) for v, d in values]
        for name, (value, tangents) in zip(target.elts, held, strict=True):
            self._bind(name, value, tangents)

    def _hold(self, value: str, tangents: Tangents) -> tuple[str, Tangents]:
        name = self._temporary(value)
        for i, d in tangents.items():
            self._emit(f"{self._d(i, name)} = {d}")
        return name, {i: self._d(i, name) for i in tangents}

    def _bind(self, target, value: str, tangents: Tangents) -> None:
        reach = self.reach.setdefault(target.id, set())
        reach |= set(tangents)
        for i in sorted(reach):
            self._emit(f"{self._d(i, target.id)} = {tangents.get(i, '0.0')}")
        self._emit(f"{target.id} = {value}")

    def _return(self, node):
        if self._helper(node.value) is not None:
            values = self._call_many(node.value)
        else:
            values = [self._value(p) for p in (node.value.elts if isinstance(node.value, ast.Tuple) else [node.value])]
        derivatives = [d.get(i, "0.0") for _, d in values for i in range(len(self.active))]
        self._emit("return " + ", ".join([v for v, _ in values] + derivatives))

    # --- expressions: text of the value and of its tangents, both free of side effects
    def _fresh(self) -> str:
        """A name that neither the author nor an earlier differentiation uses."""
        return f"w{self.mark}_{next(self.count)}"

    def _d(self, seed: int, name: str) -> str:
        """Name of a variable's derivative."""
        return f"d{self.mark}_{seed}_{name}"

    def _temporary(self, value: str) -> str:
        name = self._fresh()
        self._emit(f"{name} = {value}")
        return name

    def _value(self, node) -> tuple[str, Tangents]:
        if isinstance(node, ast.Subscript) and self._helper(node.value) is not None:
            return self._call_many(node.value)[ast.literal_eval(node.slice)]
        if isinstance(node, ast.Compare) or not self._depends(node):
            simple = isinstance(node, ast.Name | ast.Constant | ast.Attribute | ast.Call | ast.Subscript)
            return ast.unparse(node) if simple else f"({ast.unparse(node)})", {}
        if isinstance(node, ast.Name):
            return node.id, {i: self._d(i, node.id) for i in sorted(self.reach.get(node.id, ()))}
        if isinstance(node, ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, ast.BinOp):
            return self._binary(node)
        if isinstance(node, ast.IfExp):
            return self._either(ast.unparse(node.test), node.body, node.orelse)
        if isinstance(node, ast.Call):
            return self._call(node)
        raise self._unreadable(node)

    def _depends(self, node) -> bool:
        """Whether an expression contains a variable that depends on a seed."""
        return any(isinstance(n, ast.Name) and self.reach.get(n.id) for n in ast.walk(node))

    def _unary(self, node):
        if isinstance(node.op, ast.Not):
            return f"({ast.unparse(node)})", {}
        value, tangents = self._value(node.operand)
        if isinstance(node.op, ast.USub):
            return f"(-{value})", {i: f"(-{d})" for i, d in tangents.items()}
        if isinstance(node.op, ast.UAdd):
            return value, tangents
        raise self._unreadable(node)

    def _chain(self, value: str, terms: list[tuple[str, Tangents]]) -> tuple[str, Tangents]:
        """Store a value; its tangents are the sums of partial * tangent over the terms."""
        columns = sorted({i for _, t in terms for i in t})
        if not columns:
            return f"({value})", {}
        name = self._temporary(value)
        partials = [p if not t or _simple(p) else self._temporary(p.format(y=name)) for p, t in terms]
        for i in columns:
            products = [_product(p, t[i]) for p, (_, t) in zip(partials, terms, strict=True) if i in t]
            self._emit(f"{self._d(i, name)} = {' + '.join(products)}")
        return name, {i: self._d(i, name) for i in columns}

    def _binary(self, node):
        (a, da), (b, db) = self._value(node.left), self._value(node.right)
        if not da and not db:
            return f"({a} {_OPERATOR[type(node.op)]} {b})", {}
        if isinstance(node.op, ast.Add):
            return self._chain(f"{a} + {b}", [("1.0", da), ("1.0", db)])
        if isinstance(node.op, ast.Sub):
            return self._chain(f"{a} - {b}", [("1.0", da), ("-1.0", db)])
        if isinstance(node.op, ast.Mult):
            return self._chain(f"{a} * {b}", [(b, da), (a, db)])
        if isinstance(node.op, ast.Div):
            return self._chain(f"{a} / {b}", [(f"1.0 / {b}", da), (f"-{{y}} / {b}", db)])
        if isinstance(node.op, ast.Mod) and not db:
            return self._chain(f"{a} % {b}", [("1.0", da)])
        if isinstance(node.op, ast.Pow):
            return self._power(node, a, da, b, db)
        raise self._unreadable(node)

    def _power(self, node, a, da, b, db):
        terms = []
        if isinstance(node.right, ast.Constant) and node.right.value == 2:
            terms.append((f"2.0 * {a}", da))
        else:
            plain = isinstance(node.right, ast.Constant) and node.right.value not in (0, 1)
            slope = f"{b} * {a} ** ({b} - 1)"
            terms.append((slope if plain else f"({slope} if {b} != 0.0 else 0.0)", da))
        if db:
            terms.append((f"({{y}} * math.log({a}) if {a} > 0.0 else 0.0)", db))
        return self._chain(f"{a} ** {b}", terms)

    def _either(self, test: str, first, second):
        """One of two expressions, evaluated lazily like Python's own."""
        name, branches, whole = self._fresh(), [], self.lines
        for branch in (first, second):
            self.lines = []
            self.indent += 1
            value, tangents = self._value(branch)
            self._emit(f"{name} = {value}")
            branches.append((self.lines, tangents))
            self.indent -= 1
        self.lines = whole
        columns = sorted(set(branches[0][1]) | set(branches[1][1]))
        for header, (lines, tangents) in zip((f"if {test}:", "else:"), branches, strict=True):
            self._emit(header)
            self.lines += lines
            self.indent += 1
            for i in columns:
                self._emit(f"{self._d(i, name)} = {tangents.get(i, '0.0')}")
            self.indent -= 1
        return name, {i: self._d(i, name) for i in columns}

    def _extreme(self, node, sign: str):
        value, tangents = self._value(node.args[0])
        for other in node.args[1:]:
            (a, da), (b, db) = self._hold(value, tangents), self._hold(*self._value(other))
            name = self._temporary(f"{a} if {a} {sign} {b} else {b}")
            tangents = {}
            for i in sorted(set(da) | set(db)):
                self._emit(f"{self._d(i, name)} = {da.get(i, '0.0')} if {a} {sign} {b} else {db.get(i, '0.0')}")
                tangents[i] = self._d(i, name)
            value = name
        return value, tangents

    def _call(self, node) -> tuple[str, Tangents]:
        if node.keywords:
            raise self._unreadable(node)
        name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
        if name in ("max", "min"):
            return self._extreme(node, ">" if name == "max" else "<")
        helper = self._helper(node)
        if helper is not None:
            return self._call_many(node)[0]
        arguments = [self._value(a) for a in node.args]
        texts = [v for v, _ in arguments]
        call = f"{ast.unparse(node.func)}({', '.join(texts)})"
        if name in _FLAT or not any(d for _, d in arguments):
            return call, {}
        x, dx = arguments[0]
        if name == "float":
            return x, dx
        if name == "copysign":
            sign = arguments[1][0]
            return self._chain(call, [(f"math.copysign(1.0, {x}) * math.copysign(1.0, {sign})", dx)])
        if name == "abs":
            return self._chain(call, [(f"math.copysign(1.0, {x})", dx)])
        if name in _UNARY and len(arguments) == 1:
            x, dx = self._hold(x, dx)
            return self._chain(f"{ast.unparse(node.func)}({x})", [(_UNARY[name].replace("{x}", x), dx)])
        if name == "fmod" and not arguments[1][1]:
            return self._chain(call, [("1.0", dx)])
        if name == "atan2":
            (y, dy), (x, dx) = arguments
            return self._chain(call, [(f"{x} / ({x} * {x} + {y} * {y})", dy), (f"-{y} / ({x} * {x} + {y} * {y})", dx)])
        if name == "hypot":
            (a, da), (b, db) = arguments
            return self._chain(call, [(f"{a} / {{y}}", da), (f"{b} / {{y}}", db)])
        if name == "pow":
            return self._value(ast.BinOp(node.args[0], ast.Pow(), node.args[1]))
        raise self._unreadable(node)

    def _helper(self, node):
        """The library's entry of a called helper function, or None."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            return self.library.entries.get(node.func.id)
        return None

    def _call_many(self, node) -> list[tuple[str, Tangents]]:
        """Values and tangents of a call of a plain helper function."""
        helper = self._helper(node)
        if helper is None or node.keywords:
            raise self._unreadable(node)
        arguments = [self._value(a) for a in node.args]
        active = tuple(p for p, (_, d) in enumerate(arguments) if d)
        texts = ", ".join(v for v, _ in arguments)
        if not active:
            values = [self._fresh() for _ in range(helper.outputs)]
            self._emit(f"{', '.join(values)} = {helper.name}({texts})")
            return [(v, {}) for v in values]
        found = [self._fresh() for _ in range(helper.outputs * (1 + len(active)))]
        self._emit(f"{', '.join(found)} = {self.library.jacobian(helper.name, active)}({texts})")
        results = []
        for k in range(helper.outputs):
            partials = found[helper.outputs + k * len(active) :]
            terms = [(p, arguments[a][1]) for p, a in zip(partials, active, strict=False)]
            results.append(self._chain(found[k], terms))
        return results


_OPERATOR = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**", ast.FloorDiv: "//", ast.Mod: "%",
}  # fmt: skip


def _simple(partial: str) -> bool:
    return partial.isidentifier() or partial in ("1.0", "-1.0")


def _product(partial: str, tangent: str) -> str:
    return {"1.0": tangent, "-1.0": f"(-{tangent})"}.get(partial, f"{partial} * {tangent}")


assert all(hasattr(math, name) for name in _UNARY)
