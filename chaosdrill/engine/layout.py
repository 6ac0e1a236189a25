"""Where the engine keeps what: indices into the arrays of integers and doubles that a run carries."""

# settings, integers
METHOD, ORDER, QUADRATURES, SAMPLES, RECORD, ORTHOGONALISE, ABSOLUTE_TIME, MAX_EVENTS, TARGET, JACOBIAN = range(10)
SETTINGS_I = 10

# settings, doubles
TOLERANCE, PERIOD, STEP, REACH, ON_GUARD = range(5)
SETTINGS_F = 5

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
    EVALUATIONS,
) = range(16)
CARRIED_I = 16

# carried, doubles
TIME, BASE, LONGEST, PROVEN, NEXT_STEP, TRIED, STRENGTH = range(7)
CARRIED_F = 7

# columns of the event buffer before the states
EVENT_STROBES, EVENT_TIME, EVENT_KIND, EVENT_MODE, EVENT_SPEED = range(5)
EVENT_COLUMNS = 5

# columns of the table of transitions
TO_MODE, MARKS_ONLY, RANK_DEFICIENT = range(3)

# bits that describe a guard: its events change nothing, may lose rank; it is linear and free of time; its series may
# end before that of the states
MARKS, LOSES_RANK, AFFINE, UNPROVEN = 1, 2, 4, 8

(TAYLOR, RK4, DOP853) = range(3)
METHOD_CODES = {"taylor": TAYLOR, "rk4": RK4, "dop853": DOP853}

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
    EVENT,
    JUMP,
    STAGES,
) = range(14)

# arrays of a block of lanes
(
    BLOCK_T,
    BLOCK_C,
    BLOCK_X,
    BLOCK_V,
    BLOCK_WS,
    BLOCK_H,
    BLOCK_REACH,
    BLOCK_LAST,
    BLOCK_GAP,
    BLOCK_OUT,
    BLOCK_PERIOD,
    BLOCK_SIGN,
    BLOCK_SIZE,
    BLOCK_TIMES,
    BLOCK_POLYNOMIAL,
    BLOCK_BERNSTEIN,
    BLOCK_ROOT,
) = range(17)

# columns of how far a run of a batch is
STAGE, GOAL, LAST, TAKEN = range(4)
PROGRESS = 4

WIDTH = 28
"""Coefficients of a series, at most; beyond the order a row holds zeros, so that all sums have one length."""

COLUMNS = WIDTH + 4
"""Length of a workspace row: the last pass over four orders may write beyond the highest."""

# what a call of the engine ends with; values from 4 on are those of dataset.Outcome
DONE, FULL = range(2)
ESCAPED, EVENT_LIMIT, STALLED, NONFINITE, STEP_UNDERFLOW, INVALID_START, FAILED = range(4, 11)

# how a guard stands at the start of a step
ARMED, PASSED, FIRE, INVALID = range(4)

# what came before the step: more of the same phase, nothing, an event within this mode, an event that led into it
ONGOING, BEGIN, SAME_MODE, NEW_MODE = range(4)
