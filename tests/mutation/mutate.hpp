// Damages inputs as a disk, a transfer, an editor, a careless program or an attacker might.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/mutation/test_case.hpp"

namespace borelli::mutation {

/// Mutation `number` of one of the seeds: bits flipped, bytes and integers set to boundary values,
/// blocks deleted, doubled, moved, repeated or cut off, numbers in text replaced by absurd ones, tokens and
/// tails taken from other seeds, lines doubled, deleted and moved, deep nesting inserted. The same reader,
/// campaign and number give the same mutation.
TestCase mutated(const std::vector<TestCase>& seeds, std::string_view reader, std::uint64_t campaign,
                 std::uint64_t number);

}  // namespace borelli::mutation
