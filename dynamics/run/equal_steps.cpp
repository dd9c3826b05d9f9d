#include "dynamics/run/equal_steps.hpp"

#include <algorithm>
#include <cmath>

namespace borelli {

namespace {

// Shortest part, relative to the fixed step, into which contacts may divide a step.
constexpr double finest_part = 1. / 64;
constexpr int most_patience = 64;
// After this many shortest parts of a step were still too long, the rest of the step is not divided.
constexpr int most_vain = 4;

long fewest_steps(double from, double to, double step) {
  return std::max(1L, long(std::ceil((to - from) / step - 1e-9)));
}

}  // namespace

void EqualSteps::begin(double from, double target, double step) {
  target_ = target;
  from_ = from;
  count_ = fewest_steps(from, target, step);
  number_ = 1;
  whole_ = true;
  vain_ = 0;
}

double EqualSteps::step_end() const {
  return number_ == count_ ? target_ : from_ + (target_ - from_) * double(number_) / double(count_);
}

EqualSteps::Part EqualSteps::part_from(double t) const {
  const double next = step_end(), left = next - t, part = part_ * whole_step();
  const bool last = part >= left * (1 - 1e-9);
  return last ? Part{left, next} : Part{part, t + part};
}

bool EqualSteps::divisible(double h) const {
  return vain_ < most_vain && h > 1.5 * finest_part * whole_step();
}

void EqualSteps::divide(double h) {
  // Parts are successive halves; what is left of a step is one part or more.
  part_ = std::exp2(std::ceil(std::log2(h / whole_step()) - 1e-6) - 1);
  if (longer_) patience_ = std::min(2 * patience_, most_patience);
  longer_ = false;
  made_ = 0;
}

void EqualSteps::lengthen() {
  if (longer_) patience_ = std::max(1, patience_ / 2);
  longer_ = ++made_ >= patience_ && part_ < 1;
  if (!longer_) return;
  part_ *= 2;
  made_ = 0;
}

void EqualSteps::go_on() {
  number_ = number_ == count_ ? 0 : number_ + 1;
  whole_ = true;
  vain_ = 0;
}

void EqualSteps::keep(Keeper& k, double start, const SimulationSettings& settings) {
  k.within(target_, std::min(0., start), std::max(0., settings.end_time));
  k.within(from_, std::min(0., start), target_);
  k.within(count_, 0L, fewest_steps(start, settings.end_time, settings.step));
  k.within(number_, 0L, count_);
  k(whole_, part_, made_, patience_, longer_, vain_);
}

}  // namespace borelli
