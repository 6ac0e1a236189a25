"""Compiled once for all systems: steps, roots, events, tangents, and many runs side by side.

What an event is, is written once, in `guards`; every method and the lanes go by it. The end of a step, with strobes,
event and reset, is `end_step` in `step`, for one run and for each of eight. A run is one record, `RUN` in `layout`
(mode, strobes, time, what came before the step), and the arrays that go with it; compiled functions are given the
address of one record, the `Machine`: the functions of the system and of the method, settings, tables, states, scratch.
"""
