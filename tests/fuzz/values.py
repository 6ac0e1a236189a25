"""Numbers, texts and pieces of expressions that are likely to be handled wrongly."""

import re

OWNED = "zzowned"
"""Word of every text that would be code if it were run; it stands in no code of the package."""

NUMBERS = ["1e308", "-1e308", "1e400", "9" * 30, "-" + "9" * 30, "1" * 5000, "0", "-1", "-0.0", "nan", "inf", "-inf"]
NUMBERS += ["0x7fffffffffffffff", "9223372036854775808", "5e-324", "1_000_000_000", "1e10", "2.5", "1e-300"]
PLAUSIBLE = ["1000000", "1", "3", "1e-15", "0.01", "100", "1e6", "10000000000", "0.3", "2"]
OTHERS = ["true", '"text"', '""', "[]", "{}", "[[]]", "[1, 'a', {}]", "1979-05-27T07:32:00Z", "07:32:00", "1e3"]
OTHERS += ["'''\n'''"]
HOSTILE = [
    f"__import__('os').system('touch {OWNED}')",
    "os.system",
    f"$(touch {OWNED})",
    "../../../etc/passwd",
    "{0.__class__}",
    f'"""; import {OWNED}; #',
    f"'); {OWNED}(",
    f"{OWNED}\n{OWNED}()",
    f"</script><img src=x onerror={OWNED}()>",
    "&#60;script src=//a.example&#62;",
    "9**9**9",
    "(" * 20_000 + "v" + ")" * 20_000,
    "v.__class__",
    "(3*x)**999999999",
    "1/0",
    "cos(t)**2 + x/v",
    "%s%s%n",
    "\\u0000",
    "\\U0001F600",
    "\u202e\ufeff",
    "x" * 100_000,
    "chaosdrill.cli.main:main",
    "sin(x)",
    "exec('1/0')",
    "-",
    "lambda",
    "None",
    "y0",
    "d_0",
    "math",
]
"""Scenes quote them as they are: some are no text of TOML, which is another fault to be told."""

DATA = [None, True, False, 0, -1, 1, 3, 2**31, 2**63, 10**30, 10**400, 0.5, -0.0, 1e-320, 1e308, "", "x", [], {}]
DATA += [float("nan"), float("inf"), float("-inf"), [[]], {"": 0}, [None, 1, "a", {}], "inf", "-1e999", "\0", "\ud800"]

SIGNS = ["**", "*", "/", "+", "-", "(", ")", ",", "<", ">=", "==", " and ", " or ", "not ", ".", "'", "^"]
WORDS = ["sin(", "exp(", "log(", "Max(", "Mod(", "floor(", "sqrt(", "Abs(", "sign(", "Heaviside(", "pi", "E", "True"]
CONSTANTS = ["0", "1", "2", "-1", "0.5", "1/3", "1e9", "1e-9", "1e308", "999999999", "10**300", "x", "v", "t"]
TOKEN = re.compile(r"[A-Za-z_]\w*\(?|\d+\.?\d*(?:e-?\d+)?|\*\*|[<>=!]=|\S|\s+")


def expression(text, chance):
    """An expression with some of its pieces replaced, removed, repeated, wrapped or moved."""
    tokens = TOKEN.findall(text[:2000]) or ["x"]
    for _ in range(chance.choice([1, 1, 2, 4])):
        at = chance.randrange(len(tokens))
        way = chance.randrange(6)
        if way == 0:
            tokens[at] = chance.choice(SIGNS + WORDS + CONSTANTS)
        elif way == 1:
            tokens.insert(at, chance.choice(SIGNS + WORDS + CONSTANTS))
        elif way == 2 and len(tokens) > 1:
            del tokens[at]
        elif way == 3:
            end = at + chance.randrange(1, 8)
            tokens[at:at] = tokens[at:end] * chance.choice([1, 2, 5, 40])
        elif way == 4:
            word = chance.choice([word for word in WORDS if word.endswith("(")])
            tokens = (
                [word, *tokens, ")"] if chance.random() < 0.5 else ["(", *tokens, ")", "**", chance.choice(CONSTANTS)]
            )
        else:
            other = chance.randrange(len(tokens))
            tokens[at], tokens[other] = tokens[other], tokens[at]
        tokens = tokens[:4000]
    return "".join(tokens)
