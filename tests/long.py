"""What `make test` leaves to `make long`: repetitions, in minutes, of what a quicker test of the same file holds.

Each is a pattern of a test's name, by file; a pattern that matches nothing ends the run. Drawn cases are split by their seed.
"""

from __future__ import annotations

import re

LONG: dict[str, tuple[str, ...]] = {
    "site/test_commands_end.py": ("test_the_commands_of_a_page_end_as_it_says",),
    "site/test_flying_page.py": (r"\[out of reach\]",),
    "site/test_fly_around_tables.py": (r"flights_with_errors.*\[(paper|equal|fewest|16|20)",),
    "site/test_hardware_tables.py": ("test_quantiles", "test_every_mission", "papers_design_lies", "beaten_on_as_many"),
    "site/test_computer_tables.py": (r"ng_ultra\[paper00[013]", "throughput_of", r"precision\[rec1", "hold_the_fly_around"),
    "site/test_schedule_tables.py": ("what_clusters_cost",),
    "site/test_oblate_table.py": (r"\[(station_rbar|elliptic_servicing)-", r"from 600 m-True"),
    "site/test_plan_without_j2.py": (r"two_burns\[(`turn|the raise)", "one_burn_that_waits"),
    "site/test_reach_page.py": ("a_sweep_of_the_papers_grid",),
    "site/test_rtl_tables.py": ("test_each_row_that_is_printed_is_stated",),
    "site/test_stated.py": tuple(
        rf"states_what_the_plan_has\[{each}"
        for each in (
            r"approach\.md: (elliptic|impulses at|public|station_held \w|station_vbar[ _])", r"fly-around\.md: (paper001_(adaptive|equal)|paper001_fewest \w)",
            r"passive-safety\.md: paper000_(interrupted|elliptic|\d(\]| .*free))", r"phasing\.md: paper003_(chance|design)", r"plan\.md: plane",
            r"plan\.md: (wait|perigee|(raise|turn)_two_burns(\]| burn| vehicle| .*coast_j2))", r"platform-launch\.md: (.*35786|paper002_dispersed)",
        )
    ),
    # `run`, `budget`, `trace`, `throughput` and `calibrate` remain.
    "integration/test_ignored_keys.py": (
        r"\[(explain|precision|partition( by the estimate)?|budget (by the estimate|of nothing)|trace on the PS)\]",
        r"\[trace (with polling|with two cores|of a trace's estimate)\]",
    ),
    # One of each kind of end remains: after two tries the core, and a second try on the PL.
    "soc/test_faults.py": (r"fault_stays\[(registers|interrupt|reset|clock|endless)", r"goes_away\[(memories|clock)"),
    # Flat programs, a freezing decoder and clusters keep a mutant each.
    "rtl/test_mutations.py": (
        "divider counts on while the decoder freezes", "opening of a header believed", "adder one cycle longer",
        "results leave for the next cluster", "one cluster's word given to all importers", "divider reserved a cycle short",
        "addresses stepped one too far", "counter two cycles ahead", "runs of empty words one too long", "writes land in a second row",
        "divider's", "square of a root", "rest of a quotient", "counter stuck", "templates a stage early", r"programs_that_catch_mutations\[flat-engine4",
    ),
    "rtl/test_parity.py": (r"without_parity\[(in_order|flat)\]",),
    "rtl/test_exact_depth.py": (r"hosts_bits\[f64", "streamed_microcode", "is_refused"),
    "rtl/test_streamed.py": (r"hosts_bits\[(2 lanes|4 lanes f64|16 lanes)",),
    "rtl/test_resident.py": (r"single, ", r"cones 3, compressed", r"stalls twice, compressed", "a_stop_bit_that_is_not_read"),
    "board/test_board.py": ("another_answer_than_the_hosts", "a_byte_begins_it_anew"),
    "board/test_cells.py": ("one_bit_of_a_block_memory",),
    "rtl/test_route.py": (r"\[ecp5_85_8-fp_add\]",),
    "integration/test_cli_reach.py": ("while_figures_are_drawn", "what_no_report_leaves_out", "a_killed_sweep"),
    "integration/test_cli_reach_restricted.py": (r"\[(altitude, )?perigee at its bound\]", r"\[perigee direction"),
    "integration/test_cli_hw.py": ("the_opening_figure_of_the_docs",),
    "missions/reachable_insertion/two_burns/test_known_missions.py": (r"no_longer\[([89]|[123]\d)\]",),
    "missions/reachable_insertion/two_burns/test_known_pairs.py": (r"-([4-9]|1\d)\]",),
    "missions/reachable_insertion/test_bounded_search.py": (r"\[plane-[35].0\]",),
    "missions/passive_safety/test_claims.py": (r"\[([5-9]|1\d)\]",),
    "missions/fly_around/test_coasting.py": (r"either_bound\[([5-9]|1\d)\]",),
    "missions/fly_around/test_report.py": ("cycle_budget_of_the_fewest",),
    "missions/test_verdict_lines_of_all.py": (r"\[rec1-[02]\]", r"contradiction\[.*-2\]"),
    "flight/test_export.py": (r"other_machines\[32-", r"sanitizers_ask\[32"),
    "flight/test_partition.py": (r"core\[(statistics|factorization\+|matrix_)", r"restarts_run.*\[(paper|factor_only)", r"device\[paper-"),
    "flight/test_tables.py": (r"own_list\[(infeasible|quadratic|condensed)\]",),
    "guidance/test_claims.py": (r"claim\[(paper000_(interrupted|elliptic|robust)|elliptic_servicing|phasing_drift|station_vbar_dispersed)\]",),
    "hw_model/area/test_ng_ultra.py": ("a_unit_synthesised_anew",),
    "rtl/test_engine.py": (r"words\[4 lanes, 2 dividers, 16 banks\]", r"fetch\[4 lanes, 2 dividers\]"),
    "rtl/test_interleaved.py": (r"by_itself\[3-4\]",),
    "rtl/test_schedules.py": (r"models_cycles\[all\]",),
}  # fmt: skip


def pattern_of(name: str) -> tuple[str, str] | None:
    """The file and pattern by which the test of that name is a long one."""
    path, _, rest = name.removeprefix("tests/").partition("::")
    return next(((path, each) for each in LONG.get(path, ()) if re.search(each, rest)), None)
