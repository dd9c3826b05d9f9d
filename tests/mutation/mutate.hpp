// Damages inputs: what a disk, a transfer, an editor or a careless program does to a file, and what an
// attacker tries.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/mutation/test_case.hpp"

namespace borelli::mutation {

/// The mutation of this number of one of the seeds: bits flipped, bytes and integers set to boundary values,
/// blocks deleted, doubled, moved, repeated or cut off, numbers in text replaced by absurd ones, tokens and
/// tails taken from other seeds, lines doubled and swapped, deep nesting inserted. The same reader's name,
/// campaign and number give the same mutation.
TestCase mutated(const std::vector<TestCase>& seeds, std::string_view reader, std::uint64_t campaign,
                 std::uint64_t number);

}  // namespace borelli::mutation
