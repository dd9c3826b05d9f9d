// Volumes, label maps, landmarks: reading, writing, views of their voxels.
#include "python/volume.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/files/whole_file.hpp"
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/write.hpp"

namespace borelli::python {
namespace {

std::shared_ptr<NamedScan> read_scan(const py::object& path, const py::object& quantity) {
  const std::string file = path_of(path);
  ReadOptions options;
  if (!quantity.is_none()) options.quantity = value_or_throw(parse_quantity(quantity.cast<std::string>()));
  auto out = std::make_shared<NamedScan>();
  out->scan = released([&] { return read_volume(file, options); });
  out->name = std::filesystem::path(file).filename().string();
  warn(out->scan.warnings);
  return out;
}

std::shared_ptr<LabelMap> read_label_map(const py::object& path, const std::string& names,
                                         const NamedScan* scan) {
  const std::string file = path_of(path);
  auto out = std::make_shared<LabelMap>(
      released([&] { return read_labels(file, names, {}, scan ? &scan->scan.volume.grid : nullptr); }));
  warn(out->warnings);
  return out;
}

py::array array_of(const py::object& given) {
  py::array array = py::array::ensure(given);
  if (!array) refuse("voxels", "are not an array");
  return array;
}

// The grid of an array: `axes` are three spacings along x, y, z, or a matrix whose columns are the steps, mm.
Grid grid_of(const py::array& voxels, const Numbers& axes, const Numbers& origin) {
  if (voxels.ndim() != 3) refuse("voxels", fmt::format("have {} dimensions; expected 3", voxels.ndim()));
  Grid grid;
  for (int c = 0; c < 3; ++c) grid.size[static_cast<std::size_t>(c)] = voxels.shape(c);
  if (axes.ndim() == 1)
    grid.axes = vector_of(axes, 3, "axes").asDiagonal();
  else if (axes.ndim() == 2 && axes.shape(0) == 3 && axes.shape(1) == 3)
    grid.axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(axes.data());
  else
    refuse("axes", "are neither 3 spacings nor a 3 x 3 matrix");
  if (!grid.axes.allFinite() || grid.voxel_volume() == 0) refuse("axes", "span no volume");
  grid.origin = vector_of(origin, 3, "origin");
  if (!grid.origin.allFinite()) refuse("origin", "is not finite");
  return grid;
}

// The voxels of an array of any kind, i fastest, rounded. `exact`: refuses what is not nearly a whole number.
template <class T>
std::vector<T> voxels_of(py::array voxels, const std::string& what, bool exact = false) {
  using Limits = std::numeric_limits<T>;
  const char kind = voxels.dtype().kind();  // of NumPy: bool, signed, unsigned or floating-point
  if (std::string_view("biuf").find(kind) == std::string_view::npos) refuse(what, "are not real numbers");
  if (!voxels.dtype().is(py::dtype::of<T>()) && voxels.size() > 0) {
    const auto least = voxels.attr("min")().cast<double>(), most = voxels.attr("max")().cast<double>();
    if (!(least >= Limits::min() && most <= Limits::max()))
      refuse(what, fmt::format("lie between {:g} and {:g}; they must fit {} to {}", least, most,
                               int(Limits::min()), int(Limits::max())));
    if (kind == 'f') {
      const py::module_ numpy = py::module_::import("numpy");
      const py::array whole = numpy.attr("rint")(voxels);
      constexpr double most_off = 0.01;  // labels that a program stored as floating-point numbers
      if (exact && !numpy.attr("allclose")(voxels, whole, 0, most_off).cast<bool>())
        refuse(what, "are not whole numbers");
      voxels = whole;
    }
  }
  const py::array_t<T, py::array::f_style | py::array::forcecast> whole(voxels);
  return std::vector<T>(whole.data(), whole.data() + whole.size());
}

std::shared_ptr<NamedScan> scan_from(const py::object& given, const Numbers& axes, const Numbers& origin,
                                     const std::string& quantity, const std::string& name) {
  const py::array voxels = array_of(given);
  auto out = std::make_shared<NamedScan>();
  GreyVolume& volume = out->scan.volume;
  volume.grid = grid_of(voxels, axes, origin);
  const FileQuantity stored = value_or_throw(parse_quantity(quantity));
  if (stored == FileQuantity::density_gcm3)
    refuse("quantity", "of an array must be hu, density_kgm3, labels or mr");
  volume.quantity = held_as(stored);
  volume.voxels = voxels_of<std::int16_t>(voxels, "voxels");
  out->scan.reading = fmt::format("{}, as given by the caller", quantity_words(stored));
  out->name = name;
  return out;
}

std::shared_ptr<LabelMap> labels_from(const py::object& given, const Numbers& axes, const Numbers& origin,
                                      std::vector<std::string> names) {
  const py::array voxels = array_of(given);
  auto out = std::make_shared<LabelMap>();
  out->grid = grid_of(voxels, axes, origin);
  out->voxels = voxels_of<std::uint8_t>(voxels, "labels", true);
  if (names.empty())
    for (const Part& part : parts) names.emplace_back(part.name);
  for (const std::uint8_t label : out->voxels)
    if (label >= names.size()) refuse("labels", fmt::format("contain {}, which has no name", label));
  out->names = std::move(names);
  return out;
}

template <class T>
py::array voxels_view(Volume<T>& volume, const py::object& owner) {
  const auto& size = volume.grid.size;
  constexpr auto one = py::ssize_t(sizeof(T));
  return view(volume.voxels.data(), {size[0], size[1], size[2]},
              {one, one * size[0], one * size[0] * size[1]}, owner, true);
}

py::object optional_age(const NamedScan& s) {
  return s.scan.age_years ? py::cast(*s.scan.age_years) : py::object(py::none());
}

// What volumes and label maps have in common: `grid` gives the grid of one.
template <class Class, class GridOf>
void add_grid(Class& of, GridOf grid) {
  using T = typename Class::type;
  of.def_property_readonly(
        "shape",
        [grid](const T& s) {
          const auto& size = grid(s).size;
          return py::make_tuple(size[0], size[1], size[2]);
        },
        "Voxels along i, j, k.")
      .def_property_readonly(
          "spacing", [grid](const T& s) { return copy(Eigen::Vector3d(grid(s).spacing())); },
          "Lengths of the grid's steps, (3,), mm.")
      .def_property_readonly(
          "axes", [grid](const T& s) { return copy(grid(s).axes); },
          "(3, 3): column c is the step along index c, mm, LPS.")
      .def_property_readonly(
          "origin", [grid](const T& s) { return copy(grid(s).origin); },
          "Centre of voxel (0, 0, 0), (3,), mm, LPS.");
}

void add_landmarks(py::module_& m) {
  py::class_<Landmark>(m, "Landmark", "A named point of the body in the patient frame (LPS).")
      .def(py::init([](const Numbers& point, double deviation, double radius, const std::string& source) {
             return Landmark{vector_of(point, 3, "point"), deviation, radius, source};
           }),
           py::arg("point"), py::arg("deviation") = 0.0, py::arg("radius") = 0.0, py::arg("source") = "given")
      .def_property_readonly(
          "point", [](const py::object& self) { return view(self.cast<Landmark&>().point, self, true); },
          "(3,), mm. A view.")
      .def_readwrite("deviation", &Landmark::deviation, "Standard deviation of each coordinate, mm.")
      .def_readwrite("radius", &Landmark::radius, "Of the sphere or cylinder about it, mm; 0: none.")
      .def_readwrite("source", &Landmark::source, "How it was found.")
      .def("__repr__", [](const Landmark& l) {
        return fmt::format("<borelli.Landmark ({:.1f}, {:.1f}, {:.1f}) mm, sd {:.1f} mm, {}>", l.point[0],
                           l.point[1], l.point[2], l.deviation, l.source);
      });
  m.def(
      "read_landmarks",
      [](const py::object& path) {
        const GivenLandmarks given = value_or_throw(read_given_landmarks(path_of(path)));
        warn(given.warnings);
        return dict_of(given.all());
      },
      py::arg("path"), "Reads landmarks by name: our JSON, or the points of 3D Slicer (.mrk.json, .fcsv).");
  m.def(
      "write_landmarks",
      [](const py::object& path, const py::object& landmarks) {
        const Landmarks all = landmarks_of(landmarks);
        value_or_throw(write_whole(path_of(path), [&](const std::filesystem::path& part) {
          return write_landmarks(part.string(), all);
        }));
      },
      py::arg("path"), py::arg("landmarks").none(false),
      "Writes landmarks as JSON, which the program reads.");
}

void add_labels(py::module_& m) {
  py::class_<LabelMap, std::shared_ptr<LabelMap>> labels(
      m, "Labels", "A label map: the number of a part in each voxel, 0 outside the body.");
  labels
      .def(py::init(&labels_from), py::arg("voxels"), py::arg("axes"),
           py::arg("origin") = std::vector<double>{0, 0, 0}, py::arg("names") = std::vector<std::string>(),
           "A copy of an array (i, j, k). axes: 3 spacings or a (3, 3) matrix of steps, mm, LPS. "
           "names[label]; "
           "default: the sixteen parts.")
      .def_property_readonly(
          "voxels",
          [](const py::object& self) { return voxels_view<std::uint8_t>(self.cast<LabelMap&>(), self); },
          "(ni, nj, nk), uint8. A view; writing to it changes the labels.")
      .def_readonly("names", &LabelMap::names, "names[label]; names[0] is 'outside'.")
      .def(
          "write",
          [](const LabelMap& l, const py::object& path) {
            value_or_throw(write_label_files(path_of(path), l));
          },
          py::arg("path"), "Writes .nii.gz, .nii, .nrrd or .mha, and beside it the names as .tsv.")
      .def("__repr__", [](const LabelMap& l) {
        return fmt::format("<borelli.Labels {} x {} x {}, {} names>", l.grid.size[0], l.grid.size[1],
                           l.grid.size[2], l.names.size());
      });
  add_grid(labels, [](const LabelMap& l) -> const Grid& { return l.grid; });
  m.def("read_labels", &read_label_map, py::arg("path"), py::kw_only(), py::arg("names") = "",
        py::arg("volume") = py::none(),
        "Reads a label map of body parts. names: a TSV file (default: the one beside the map). volume: the "
        "scan "
        "on whose grid the labels are wanted.");
}

}  // namespace

py::dict dict_of(const Landmarks& landmarks) {
  py::dict out;
  for (const auto& [name, landmark] : landmarks) out[py::str(name)] = landmark;
  return out;
}

Landmarks landmarks_of(const py::object& given) {
  Landmarks out;
  if (given.is_none()) return out;
  for (const auto& [name, value] : given.cast<py::dict>()) {
    const auto key = name.cast<std::string>();
    if (py::isinstance<Landmark>(value))
      out[key] = value.cast<Landmark>();
    else
      out[key] = {vector_of(numbers_of(py::reinterpret_borrow<py::object>(value), "landmark " + key), 3,
                            "landmark " + key),
                  0, 0, "given"};
    if (!out[key].point.allFinite()) refuse("landmark " + key, "is not finite");
  }
  return out;
}

void add_volumes(py::module_& m) {
  add_landmarks(m);
  py::class_<NamedScan, std::shared_ptr<NamedScan>> volume(
      m, "Volume", "A scan: CT numbers, densities or MR signal on a grid in the patient frame (LPS, mm).");
  volume
      .def(
          py::init(&scan_from), py::arg("voxels"), py::arg("axes"),
          py::arg("origin") = std::vector<double>{0, 0, 0}, py::arg("quantity") = "hu",
          py::arg("name") = "array",
          "A copy of an array (i, j, k), rounded to int16. axes: 3 spacings or a (3, 3) matrix of steps, mm, "
          "LPS. quantity: hu, density_kgm3 or mr.")
      .def_property_readonly(
          "voxels",
          [](const py::object& self) {
            return voxels_view<std::int16_t>(self.cast<NamedScan&>().scan.volume, self);
          },
          "(ni, nj, nk), int16: HU, kg/m^3 or signal. A view; writing to it changes the volume.")
      .def_property_readonly(
          "quantity", [](const NamedScan& s) { return quantity_name(s.scan.volume.quantity); },
          "hu, density_kgm3, labels or mr.")
      .def_readonly("name", &NamedScan::name, "Of the file.")
      .def_property_readonly(
          "reading", [](const NamedScan& s) { return s.scan.reading; },
          "What the voxels hold and why it was chosen.")
      .def_property_readonly(
          "format", [](const NamedScan& s) { return s.scan.format; }, "Of the file.")
      .def_property_readonly(
          "pose", [](const NamedScan& s) { return s.scan.pose; },
          "How the person lay, from DICOM; '' if not stated.")
      .def_property_readonly(
          "sex", [](const NamedScan& s) { return s.scan.sex; },
          "male or female, from DICOM; '' if not stated.")
      .def_property_readonly("age", &optional_age, "Years, from DICOM; None if not stated.")
      .def_property_readonly(
          "warnings", [](const NamedScan& s) { return s.scan.warnings; },
          "What was chosen, corrected or ignored in reading.")
      .def(
          "write",
          [](const NamedScan& s, const py::object& path) {
            const std::string file = path_of(path);
            value_or_throw(write_whole(file, [&](const std::filesystem::path& part) {
              return write_volume(part.string(), s.scan.volume);
            }));
          },
          py::arg("path"), "Writes .nii.gz, .nii, .nrrd or .mha. NIfTI holds the grid in seven digits.")
      .def("__repr__", [](const NamedScan& s) {
        const Grid& grid = s.scan.volume.grid;
        return fmt::format("<borelli.Volume '{}', {} x {} x {} voxels of {:.3g} x {:.3g} x {:.3g} mm, {}>",
                           s.name, grid.size[0], grid.size[1], grid.size[2], grid.spacing()[0],
                           grid.spacing()[1], grid.spacing()[2], quantity_name(s.scan.volume.quantity));
      });
  add_grid(volume, [](const NamedScan& s) -> const Grid& { return s.scan.volume.grid; });
  m.def("read_volume", &read_scan, py::arg("path"), py::kw_only(), py::arg("quantity") = py::none(),
        "Reads a CT, density or MR volume: a folder of DICOM slices, NIfTI, NRRD or MetaImage.\n\n"
        "quantity: hu, density_kgm3, density_gcm3, labels or mr; default: what the file says.\n"
        "Raises Error that names the file; doubts are DoubtWarnings and stay in `warnings`.");
  add_labels(m);
}

}  // namespace borelli::python
