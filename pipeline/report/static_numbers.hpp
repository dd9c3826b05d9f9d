// The report's numbers as plain HTML, for readers without JavaScript. The page's program puts its own views
// in their place.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace borelli {

/// Title, warnings, the motion's verdict and the inertia table from the page's data (`subject`, `table`,
/// `run`, `motion` as report_page writes them; what is missing is left out).
std::string static_numbers(const nlohmann::json& report);

}  // namespace borelli
