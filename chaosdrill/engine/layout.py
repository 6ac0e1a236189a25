"""Where the engine keeps what: indices into the arrays of integers and doubles that a run carries."""

# settings, integers
METHOD, ORDER, QUADRATURES, SAMPLES, RECORD, ORTHOGONALISE, ABSOLUTE_TIME, MAX_EVENTS, TARGET = range(9)
SETTINGS_I = 9

# settings, doubles
TOLERANCE, PERIOD, STEP = range(3)
SETTINGS_F = 3

# carried, integers
(
    MODE,
    STROBES,
    LIVE,
    FRESH,
    FIRED,
    SAMPLE,
    SAMPLE_ROWS,
    EVENT_ROWS,
    STEPS,
    TIES,
    EVENTS_IN_PERIOD,
    STALL,
    QR_WAIT,
    QR_SINCE,
    RANK_CHECK,
) = range(15)
CARRIED_I = 15

# carried, doubles
TIME, BASE, LONGEST, PROVEN = range(4)
CARRIED_F = 4

# columns of the event buffer before the states
EVENT_STROBES, EVENT_TIME, EVENT_KIND, EVENT_MODE, EVENT_SPEED = range(5)
EVENT_COLUMNS = 5

# columns of the table of transitions
TO_MODE, MARKS_ONLY, RANK_DEFICIENT = range(3)

(TAYLOR, RK4) = range(2)
METHOD_CODES = {"taylor": TAYLOR, "rk4": RK4}

# arrays of scratch
(
    WORKSPACE,
    POLYNOMIAL,
    SHIFTED,
    STACK,
    ENDS,
    TIMES,
    GRADIENT,
    BEFORE,
    AFTER,
    OUT,
    IMAGE,
    RESET_JACOBIAN,
    JUMP,
    STAGES,
    MOVED,
    NONE,
) = range(16)

# what a call of the engine ends with; values from 4 on are those of dataset.Outcome
DONE, FULL = range(2)
ESCAPED, EVENT_LIMIT, STALLED, NONFINITE, STEP_UNDERFLOW, INVALID_START = range(4, 10)

# how a guard stands at the start of a step
ARMED, PASSED, FIRE, INVALID = range(4)

# what came before the step: more of the same phase, nothing, an event within this mode, an event that led into it
ONGOING, BEGIN, SAME_MODE, NEW_MODE = range(4)
