"""Numbers that tune pictures, with their reasons; none of them is a result."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What is drawn up to which number and size; heights and widths are in inches, texts and marks in points."""

    # pages
    font_size: float = 9.0
    """Size of the text of pictures, that of notes in a journal."""
    page_font_size: float = 10.5
    """The same on a page."""
    page_width: float = 10.5
    """Width in inches of the pictures of a page, which a screen enlarges and paper reduces."""
    narrow: float = 5.0
    """Width in inches, for text of the default size, below which panels are stacked: half is too narrow for labels."""
    low: float = 0.6
    """Height in inches, for text of the default size, below which a panel has no room for its label and its ticks."""
    legend_line: float = 1.7
    """Height of a line of a legend, in sizes of its text."""
    densest: float = 300.0
    """Dots an inch up to which the cells of a plane make a picture denser: no eye sees more."""
    most_panels: int = 12
    """Largest number of panels, one per state or exponent, unless states are named: more cannot be read on a page."""

    # texts
    fewest_letters: int = 6
    """Smallest number of letters in a line of broken text."""
    smallest_text: float = 0.6
    """Smallest part of its size to which a text shrinks whose words are longer than its room."""
    label_rounds: int = 3
    """Breaking a label changes the room of others; after this number of rounds nothing changes."""
    edge: float = 4.0
    """Points between a text and the edge of the figure."""
    most_decimals: int = 6
    """Digits after the decimal point beyond which a short value is written with a power of ten."""

    # markers
    smallest_mark: float = 3.0
    """Width of the smallest marks, in points."""
    merged_marks: float = 1.5
    """Distance in points at which marks merge into one."""

    # trajectories
    visible_bend: float = 2e-3
    """Fraction of the picture's width below which a bend is invisible."""
    visible_jump: float = 1e-6
    """Part of a state's range below which a jump is no jump: what setting a state anew leaves of rounding."""
    turn: float = math.radians(4.0)
    """A line that turns by more than this from one stretch to the next looks like a polygon."""
    coarse_turn: float = math.radians(20.0)
    """A line that turns by more than this from one sample to the next is sampled coarsely."""
    coarse_share: float = 0.02
    """If lines do so at more than this fraction of the samples, slopes are computed from the equations."""
    most_stretches: int = 24
    """Number of stretches between two samples."""
    marked_events: int = 40
    """More events on one page cannot be distinguished; several runs share this number."""
    fewest_events: int = 8
    """Events that each of several runs shows at least."""

    # animations
    longest_animation: float = 60.0
    """Seconds of the longest animation: with the two below they bound memory and file."""
    frame_rate: int = 20
    """Frames a second, as many as look smooth."""
    frame_density: int = 100
    """Dots an inch of a frame, those of a screen."""
    trail: float = 1.5
    """Seconds for which the trail of the point stays visible."""
    flash: float = 0.3
    """The same of an event."""
    gif_shades: int = 6
    """Shades of each colour of a GIF towards white, for the edges of lines; the same in all frames, against flicker."""

    # diagrams and sections
    flat: float = 1e-6
    """Variation of a state, as a part of its size, below which it is constant."""
    jump_of_section: float = 12.0
    """A step this many times longer than those around it leads to another attractor."""
    leap_of_section: float = 0.1
    """So does a step by this fraction of the extent where period or outcome change."""
    visible_in_section: float = 0.02
    """Part of the extent below which a step is invisible."""
    named_rows: int = 24
    """Largest number of seeds whose rows have names; more share the same height."""
    one_point: float = 1e-5
    """Extent, as a part of the size, that the digits of an axis do not show."""
    visible_growth: float = 1e-9
    """Logarithm of the growth between two points of the section below which exponents are those of rounding."""
    zero_growth: float = 0.1
    """The same at the ends of the axis of exponents that all are 0 but for rounding."""
    many_points: int = 5000
    """Number of points from which a vector format stores them as an image."""
    cobweb_steps: int = 40
    """Number of returns in a cobweb, from the first point on: more would fill the picture."""

    # charts, basins and attractors
    exponents_covered: float = 99.0
    """The few exponents beyond this percentile on either side, near superstable cycles above all, do not set the
    scale."""
    rates_covered: float = 99.9
    """The few rates beyond this percentile, of runs about to escape above all, do not set the scale."""
    nonzero_errors: float = 3.0
    """An exponent counts as nonzero beyond this number of standard errors."""
    nonzero_part: float = 1e-9
    """Nor does one below this fraction of the largest exponent."""
    counted_attractors: int = 8
    """Most attractors that are counted: more steps of lightness cannot be distinguished."""
    told_attractors: int = 12
    """Largest number of attractors that are distinguished, or have their own band; the legend has no room, and the
    palette no colours, for more."""
    chart_height: float = 5.5
    """Height in inches of the figure without its legend."""
    legend_letters: int = 54
    """Letters of a legend entry up to which two stand side by side."""
    in_plane: float = 1e-6
    """Distance from the plane of the grid, relative to the state, at which a point still lies in it."""
    most_planes: int = 9
    """Largest number of planes on a page: three rows of three."""
    dark: float = 0.45
    """Lightness of a region below which its name is white."""
    beside: float = 0.9
    """Inches of a figure's width that are reserved for labels."""
    region_text: float = 8 / 9
    """Size of the names in regions, as a fraction of that of text."""
    letter_width: float = 0.62
    """Mean width of a letter, in sizes of the text."""
    inside_region: float = 0.88
    """Fraction of a name's box that must lie within its region."""
    named_regions: int = 3
    """Number of regions of one category that are named, largest first."""
    shares_height: float = 4.4
    """Height in inches."""
    error_bars: int = 60
    """Largest number of values with error bars: more would hide the bands."""

    # orbits, branches, equilibria, manifolds
    told_events: int = 12
    """Largest number of events of a period that the title lists in order."""
    least_residual: float = 1e-17
    """A residual of zero is drawn here, below all that round-off yields."""
    smallest_modulus: float = 1e-3
    """Smaller moduli are not shown: they do not matter for stability."""
    circle_up_to: float = 1.25
    """Largest modulus around which the unit circle is drawn at least."""
    widened_up_to: float = 1.5
    """Modulus up to which multipliers widen the picture."""
    special_mark: float = 6.5
    """Width in points of a special point's mark."""
    foot_mark: float = 5.0
    """The same at the foot of a panel, where marks only tell where something is."""
    branch_bar: float = 11.0
    """Length in points of the bar that marks where events change."""
    crowd: int = 16
    """Number of special points from which a crowded part gets its own panel."""
    crowd_share: float = 0.6
    """Share of them that stands in that part."""
    crowd_part: float = 0.36
    """The largest part of the range that it takes."""
    jump_of_branch: float = 12.0
    """A step of the section this many times longer than both its neighbours is a jump."""
    visible_on_branch: float = 0.01
    """Jumps below this fraction of the extent are invisible."""
    most_breaks: int = 60
    """Breaks of one kind up to which they are marked: more hide the curves."""
    manifold_height: float = 4.6
    """Height in inches."""

    # measures
    panel_height: float = 3.2
    """Height in inches of one panel alone, or of the first one."""
    note_height: float = 2.0
    """And of a picture that only says why there is nothing to draw."""
    further_panel: float = 2.2
    """And of one of several alike, or of one below."""
    most_vectors: int = 150
    """Largest number of points with vectors: more would cover each other."""
    most_splits: int = 6
    """Largest number of distributions of angles that can be distinguished."""
    vector_length: float = 0.05
    """Length of a vector, as a fraction of the plane's extent."""
    angles_height: float = 2.3
    """Height in inches of the distributions of angles."""
    sums_height: float = 2.0
    """Height in inches of the correlation sums."""
    slopes_height: float = 2.8
    """And of their slopes, which are to be read."""
    highest_slope: float = 1.7
    """Upper limit of the slopes, relative to the largest dimension: those of few pairs scatter widely."""
    slopes_aside: float = 0.06
    """Fraction of the step between two distances by which the slopes of the next order are shifted."""
    survival_height: float = 2.8
    """Height in inches of the lifetimes."""
    saddle_height: float = 3.0
    """And of the saddle."""
    settled: float = 0.05
    """The scale of a panel is set by what the running mean does after this part of the run."""
    most_digits: float = 16.5
    """Digits that an error of rounding has."""
    digits_width: int = 17
    """Digits that the axis of a bar has room for."""
    title_letters: int = 54
    """Letters in a line of a panel's title."""


TUNING = Tuning()
