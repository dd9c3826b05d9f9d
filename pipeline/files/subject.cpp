#include "pipeline/files/subject.hpp"

#include <fmt/core.h>

namespace borelli {

Subject subject_of(const ScannedVolume& scan, const std::string& said_sex) {
  Subject subject{said_sex, {}};
  const bool child = scan.age_years && *scan.age_years < adult_from;
  if (!said_sex.empty() && !scan.sex.empty() && said_sex != scan.sex)
    subject.notes.push_back(
        fmt::format("the DICOM header says {}; --sex {} was used instead", scan.sex, said_sex));
  if (said_sex.empty() && !scan.sex.empty() && !child) {
    subject.sex = scan.sex;
    subject.notes.push_back(fmt::format("sex {} comes from the DICOM header (--sex overrides it)", scan.sex));
  }
  if (child)
    subject.notes.push_back(
        fmt::format("the DICOM header gives an age of {:.2g} years: parts are found and measured as in "
                    "adults, and published values, which are for adults, {}",
                    *scan.age_years,
                    said_sex.empty() ? "are not shown (--sex shows them)" : "are shown because of --sex"));
  return subject;
}

}  // namespace borelli
