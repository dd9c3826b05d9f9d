// Coded terminology of a segment: the class that a code of SNOMED CT (or its meaning in words) and a side
// name.
//
// DICOM PS3.3, C.8.20.4 (Segmented Property Type, its modifier, Anatomic Region); 3D Slicer writes the same
// into a segment's tags (slicer.readthedocs.io, developer guide, Segmentations, "TerminologyEntry").
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// A code as DICOM and Slicer have it.
struct CodedTerm {
  std::string scheme;   ///< SCT, SRT, FMA, ...
  std::string value;    ///< 71341001
  std::string meaning;  ///< Femur
};

struct SegmentTerms {
  CodedTerm type, modifier, region, region_modifier;
};

/// The class of data/terminology.tsv that the terms name (femur_left); empty where they name none.
std::string class_of_terms(const SegmentTerms& terms);

/// The terms in a segment's tags ("TerminologyEntry:...~SCT^...^...~...|..."); empty ones where there are
/// none.
SegmentTerms terms_in_tags(std::string_view tags);

/// Other forms of a segment's name: its side at the end ("Left femur" is femur_left).
std::vector<std::string> other_forms(std::string_view name);

}  // namespace borelli
