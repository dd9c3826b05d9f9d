// Maps a segment's coded terminology to a class and back: a SNOMED CT code (or its meaning in words) and a
// side.
//
// DICOM PS3.3, C.8.20.4 (Segmented Property Type, its modifier, Anatomic Region). 3D Slicer writes the same
// into a segment's tags (slicer.readthedocs.io, developer guide, Segmentations, "TerminologyEntry").
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// A code as in DICOM and 3D Slicer.
struct CodedTerm {
  std::string scheme;   ///< SCT, SRT, FMA, ...
  std::string value;    ///< 71341001
  std::string meaning;  ///< Femur
};

struct SegmentTerms {
  CodedTerm type, modifier, region, region_modifier;
};

/// The class of data/terminology.tsv that the terms name (femur_left); empty if there is none.
std::string class_of_terms(const SegmentTerms& terms);

/// The terms of a part (data/part_terms.tsv) or of a class (data/terminology.tsv), for a file that is
/// written; "Tissue" for other names, as 3D Slicer has it.
SegmentTerms terms_of_class(std::string_view name);

/// The terms in a segment's tags ("TerminologyEntry:...~SCT^...^...~...|..."); empty terms if absent.
SegmentTerms terms_in_tags(std::string_view tags);

/// Other forms of a segment's name, with the side moved to the end ("Left femur" becomes "femur_left").
std::vector<std::string> other_forms(std::string_view name);

}  // namespace borelli
