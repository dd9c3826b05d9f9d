// The extension module borelli._core. Each file beside this one adds its part.
#include <fmt/core.h>

#include <new>

#include "pipeline/charts/chart_page.hpp"
#include "process/memory.hpp"
#include "python/common.hpp"
#include "threads/slabs.hpp"

namespace borelli::python {
namespace {

// the two types of Python that sentences go by; they live as long as the interpreter
PyObject* error_type = nullptr;
PyObject* warning_type = nullptr;

// A sentence may quote a file that is not UTF-8.
py::str text_of(const std::string& sentence) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(sentence.data(), py::ssize_t(sentence.size()), "replace"));
}

void raise(const Error& error) {
  const py::object raised = py::reinterpret_borrow<py::object>(error_type)(text_of(error.message()));
  raised.attr("where") = text_of(error.where);
  raised.attr("what") = text_of(error.what);
  raised.attr("kind") = error.kind == Error::Kind::use ? "use" : "failure";
  PyErr_SetObject(error_type, raised.ptr());
}

void add_types(py::module_& m) {
  error_type = PyErr_NewExceptionWithDoc(
      "borelli.Error",
      "What borelli cannot do, as one sentence.\n\n"
      "where: file, file:line, solid, joint or constraint that it is about (str)\n"
      "what: what was found and expected, what to do (str)\n"
      "kind: 'use' (the request is wrong) or 'failure' (it could not be carried out)",
      PyExc_Exception, nullptr);
  warning_type = PyErr_NewExceptionWithDoc("borelli.DoubtWarning",
                                           "What makes an input or a result doubtful, as one sentence.",
                                           PyExc_UserWarning, nullptr);
  m.attr("Error") = py::reinterpret_borrow<py::object>(error_type);
  m.attr("DoubtWarning") = py::reinterpret_borrow<py::object>(warning_type);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Failure& failure) {
      raise(failure.error);
    }
  });
}

void set_memory(const std::string& size) {
  const auto bytes = bytes_from(size);
  if (!bytes) refuse(size, "is not an amount of memory; expected a number and a unit, e.g. 4G or 500M");
  set_memory_limit(*bytes);
}

void set_threads(int threads) {
  if (threads < 1)
    refuse("threads", fmt::format("{} is not a number of threads; expected 1 or more", threads));
  all_threads = threads;
}

}  // namespace

Numbers numbers_of(const py::object& given, const std::string& what) {
  Numbers numbers = Numbers::ensure(given);
  if (!numbers) refuse(what, "is not an array of numbers");
  return numbers;
}

Eigen::VectorXd vector_of(const Numbers& numbers, Eigen::Index size, const std::string& what) {
  if (numbers.ndim() != 1 || numbers.size() != size) {
    std::string shape;
    for (py::ssize_t n = 0; n < numbers.ndim(); ++n)
      shape += fmt::format("{}{}", n == 0 ? "" : ", ", numbers.shape(n));
    refuse(what, fmt::format("has the shape ({}); expected ({})", shape, size));
  }
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), size);
}

Eigen::VectorXd optional_vector(const py::object& numbers, Eigen::Index size, const std::string& what) {
  return numbers.is_none() ? Eigen::VectorXd() : vector_of(numbers_of(numbers, what), size, what);
}

std::string framed(const std::string& page, int height) {
  return fmt::format(R"(<iframe srcdoc="{}" width="100%" height="{}" style="border:0"></iframe>)",
                     html_text(page), height);
}

std::string html_table(const std::vector<std::vector<std::string>>& rows, const std::string& caption) {
  std::string out = "<table>";
  if (!caption.empty()) out += "<caption>" + html_text(caption) + "</caption>";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const char* const cell = r == 0 ? "th" : "td";
    out += "<tr>";
    for (const std::string& text : rows[r]) out += fmt::format("<{}>{}</{}>", cell, html_text(text), cell);
    out += "</tr>";
  }
  return out + "</table>";
}

void warn(const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences)
    if (PyErr_WarnEx(warning_type, text_of(sentence).cast<std::string>().c_str(), 1) != 0)
      throw py::error_already_set();
}

std::string path_of(const py::object& path) {
  const py::object text = py::reinterpret_steal<py::object>(PyOS_FSPath(path.ptr()));
  if (!text) throw py::error_already_set();
  return text.cast<std::string>();
}

}  // namespace borelli::python

PYBIND11_MODULE(_core, m) {
  using namespace borelli::python;
  m.attr("__version__") = BORELLI_VERSION;
  m.attr("__module__") = "borelli";  // the name that users know its classes by
  add_types(m);
  m.def(
      "set_memory_limit", &set_memory, py::arg("size"),
      "Sets the most memory that borelli may use, e.g. '4G' (default: three quarters of what is free). Call "
      "it before any work.");
  m.def("set_threads", &set_threads, py::arg("threads"),
        "Sets the number of threads that threads=0 stands for (default: as many as the machine has).");
  add_scene(m);
  add_equations(m);
  add_batches(m);
  add_simulation(m);
  add_charts(m);
  add_volumes(m);
  add_segmentation(m);
  add_tables(m);
}
