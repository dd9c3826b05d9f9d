#include "dynamics/run/checkpoint.hpp"

#include <fmt/format.h>

#include <array>
#include <cstring>

namespace borelli {

namespace {

// Appends every setting exactly: numbers in hexadecimal, choices as their words.
struct SettingSignature {
  std::string& out;
  void operator()(const char*, bool yes) { out += yes ? "1 " : "0 "; }
  void operator()(const char*, double number) { out += fmt::format("{:a} ", number); }
  void operator()(const char*, const std::string& text) { out += text + " "; }
  template <class Choice>
  void operator()(const char*, Choice choice, const std::array<std::string_view, 2>& words) {
    out += fmt::format("{} ", words[std::size_t(choice)]);
  }
};

}  // namespace

std::string run_signature(const System& system, const State& start, const SimulationSettings& settings) {
  std::string out = fmt::format("{} {} {} {} ", system.nq, system.nv, system.rows, system.contacts.size());
  SimulationSettings::fields(settings, SettingSignature{out});
  for (const double x : start.q) out += fmt::format("{:a} ", x);
  for (const double x : start.v) out += fmt::format("{:a} ", x);
  return out + fmt::format("{:a}", start.t);
}

std::string write_checkpoint(std::string signature, const std::function<void(Keeper&)>& keep) {
  Keeper k;
  k(signature);
  keep(k);
  std::uint64_t digest = checksum_of(k.bytes());
  k(digest);
  return k.bytes();
}

Result<void> read_checkpoint(std::string_view checkpoint, const std::string& signature,
                             const std::function<void(Keeper&)>& keep) {
  const auto damaged = [] { return failure("checkpoint", "is damaged; remove it to start again"); };
  std::uint64_t digest = 0;
  if (checkpoint.size() < sizeof digest) return damaged();
  const std::string_view content = checkpoint.substr(0, checkpoint.size() - sizeof digest);
  std::memcpy(&digest, content.data() + content.size(), sizeof digest);
  if (digest != checksum_of(content)) return damaged();
  Keeper k{std::string(content)};
  std::string run;
  k(run);
  if (run != signature)
    return bad_use("checkpoint",
                   "belongs to another run (another scene, start or settings); remove it to start again");
  keep(k);
  if (!k.whole())
    return bad_use("checkpoint", "does not fit this version of the program; remove it to start again");
  return {};
}

}  // namespace borelli
