r"""Formulas of docstrings in LaTeX: `F = K delta^n` is F = K \delta^{n}."""

import re

GREEK = "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi"
GREEK += " chi psi omega"
SYMBOLS = {n: f"\\{n}" for name in GREEK.split() for n in (name, name.capitalize())}
SYMBOLS |= {"eps": "\\varepsilon", "infinity": "\\infty", "inf": "\\infty", "integral": "\\int"}
FUNCTIONS = {"sin", "cos", "tan", "tanh", "exp", "ln", "log", "max", "min", "arccos", "arctan"}
NAMED = {"sgn", "sign", "artanh", "atan2", "STEP"}
SIGNS = {"<=": "\\le ", ">=": "\\ge ", "<<": "\\ll ", ">>": "\\gg ", "->": "\\to "}
SIGNS |= {"*": "\\,", "%": "\\%"}
TOKEN = re.compile(
    r"\[[^\]]{1,12}\]$|[A-Za-z]\d+|[A-Za-z]+\*?(?:_\w+)?'*|\d+(?:\.\d+)?(?:e-?\d+)?|<=|>=|<<|>>|->|\s+|."
)
UNIT = re.compile(r"\[[^\]]{1,12}\]$")
WORD = re.compile(r"[A-Za-z]{2,}")
FEW = 4  # words of a line of formulas, as in "for delta > 0, else 0"
#: a formula with its unit, at the start of a text
HEAD = re.compile(r"^([A-Za-z]\w{0,4}'? = [^\[\]]*? \[[^\]]{1,12}\])(.*)")


def is_formula(lines: list[str]) -> bool:
    """A paragraph is formulas: one has a sign of equality, none has many words."""
    symbols = SYMBOLS.keys() | FUNCTIONS | NAMED
    counts = [len([w for w in WORD.findall(line) if w not in symbols]) for line in lines]
    return any(" = " in line for line in lines) and max(counts) <= FEW


def latex(line: str) -> str:
    """A formula in LaTeX."""
    tokens = TOKEN.findall(line.strip())
    text = re.sub(r" {2,}", " ", _joined(tokens)).strip()
    return re.sub(r" \\text\{([A-Za-z]+)\}(?= )", r"\\;\\text{\1}\\;", text)


def _joined(tokens: list[str]) -> str:
    """Tokens up to the end, brackets of powers and roots as groups."""
    out, i = [], 0
    while i < len(tokens):
        token, i = tokens[i], i + 1
        if token in ("^", "sqrt") and i < len(tokens):
            group, i = _group(tokens, i)
            out.append(f"^{{{group}}}" if token == "^" else f"\\sqrt{{{group}}}")
        elif len(token) > 1 and token.isspace():
            out.append("\\quad ")
        else:
            out.append(_symbol(token))
    return "".join(out)


def _group(tokens: list[str], i: int) -> tuple[str, int]:
    """The operand of a power or a root: a bracket, or a token with its sign; and its end."""
    if tokens[i] != "(":
        end = i + 2 if tokens[i] == "-" else i + 1
        return _joined(tokens[i:end]), end
    depth, end = 1, i + 1
    while depth and end < len(tokens):
        depth += {"(": 1, ")": -1}.get(tokens[end], 0)
        end += 1
    return _joined(tokens[i + 1 : end - 1]), end


def _symbol(token: str) -> str:
    """One token."""
    if UNIT.match(token):
        return f"\\quad\\text{{{token}}}"
    if not token[0].isalpha():
        return SIGNS.get(token, token)
    letters = token.rstrip("'")
    primes, (base, _, index) = token[len(letters) :], letters.partition("_")
    text = _word(base)
    if index:
        text += f"_{{{_word(index) if len(index) > 1 else index}}}"
    return f"{text}{primes}"


def _word(name: str) -> str:
    """A name without index."""
    if name in SYMBOLS:
        return f"{SYMBOLS[name]} "
    if name in FUNCTIONS:
        return f"\\{name} "
    if name in NAMED:
        return f"\\operatorname{{{name}}} "
    if name[-1].isdigit() and name[0].isalpha():
        return f"{name[0]}_{{{name[1:]}}}"
    if name.endswith("*"):
        return f"{_word(name[:-1])}^*"
    if len(name) == 1 or name.isdigit():
        return name
    if name == "DR":
        return "\\Delta R"
    return f"\\text{{{name}}}"
