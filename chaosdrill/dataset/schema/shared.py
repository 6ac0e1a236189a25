"""Variables that several kinds of analysis have."""

from chaosdrill.dataset.schema.variable import Table, axis, may

STATE = axis("state_name", "state", "str", "name of the state", "Label of each entry of the dimension state.", True)
STATE_LABEL = axis("state_long_name", "state", "str", "long name of the state", "What each state is, for people.")
EXPONENT = axis("exponent", "exponent", "i4", "index of the exponent", "Exponents are in descending order, from 1.")
ITERATE = axis("iterate", "iterate", "i4", "index of the iterate", "Number of the crossing of the section, from 0.")
SEED = axis("seed", "seed", "i4", "index of the seed", "Number of the initial state that the point started from.")
SEED_NAME = axis("seed_name", "seed", "str", "name of the seed", "How it starts: fixed, random, forward, backward.")
MULTIPLIER = axis(
    "multiplier", "multiplier", "i4", "index of the multiplier", "In descending order of modulus, from 1."
)
FORCING = may("forcing_period", "", "f8", "forcing period", "Period of the forcing, in units of model time.")
OUTCOME = ("How the run ended; what each code means is in flag_meanings.", "1", "outcome")
GRAZING = "Smallest over all events; tangents grow without bound as it goes to zero. Infinite without events."

_RATES = (
    ("progression_rate", "mean progression rate", "Penetration per unit of model time; of a cycle over whole ones."),
    ("progression_error", "standard error of the progression rate", "Twice it covers the truth in 95 %."),
    ("events_per_period", "events per forcing period", "All state-changing events; of a cycle over whole ones."),
    ("impacts_per_period", "impacts per forcing period", "Events of the class impact; of a cycle over whole ones."),
    ("slips_per_period", "slip onsets per forcing period", "Events of the class slip; of a cycle over whole ones."),
    ("events_per_time", "events per unit of time", "For systems without a forcing period."),
    ("impacts_per_time", "impacts per unit of time", "For systems without a forcing period."),
    ("slips_per_time", "slip onsets per unit of time", "For systems without a forcing period."),
)


SI = "For scenes given in SI units."
FORCING_SI = may("forcing_period_si", "", "f8", "forcing period", SI, "s")


def rates(dims: str) -> Table:
    """The mean rates, one number a run, and the progression rate in SI units for scenes given in SI."""
    return (
        *(may(name, dims, "f8", long_name, doc) for name, long_name, doc in _RATES),
        may("progression_rate_si", dims, "f8", "mean progression rate", SI, "m h-1"),
        may("progression_error_si", dims, "f8", "standard error of the progression rate", SI, "m h-1"),
    )
