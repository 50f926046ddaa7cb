// The rules of a schedule that the engine asserts (docs/pl-machine.md), in the order of their bits.
#pragma once

constexpr const char *RULES[] = {"read_conflict",  "read_pending", "write_pending",  "result_conflict",
                                 "write_conflict", "divider_busy", "read_unwritten", "unknown_operation"};
constexpr int RULE_COUNT = sizeof RULES / sizeof *RULES;
