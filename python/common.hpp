// What all bindings share: errors as exceptions, views of our arrays as NumPy arrays, work without the GIL, a
// watch that stops long work.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <chrono>
#include <exception>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli::python {

namespace py = pybind11;

/// An Error on its way to Python, where it becomes borelli.Error.
struct Failure : std::exception {
  explicit Failure(Error e) : error(std::move(e)), message(error.message()) {}
  const char* what() const noexcept override { return message.c_str(); }
  Error error;
  std::string message;
};

[[noreturn]] inline void refuse(std::string where, std::string what) {
  throw Failure({std::move(where), std::move(what), Error::Kind::use});
}

/// The value of a Result; throws Failure if there is none.
template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw Failure(std::move(result.error()));
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// Runs `work`, which touches no Python object, without the GIL. `work` returns a Result, or a plain value.
template <class Work>
auto released(Work&& work) {
  auto done = [&] {
    const py::gil_scoped_release release;
    return work();
  }();
  if constexpr (requires { done.error(); })
    return value_or_throw(std::move(done));
  else
    return done;
}

/// Asks during long work, without the GIL held, whether to go on: calls the user's callback if there is one,
/// and every 50 ms lets Python handle its signals. What either of them raises ends the work.
class Watch {
 public:
  explicit Watch(py::object callback) : callback_(std::move(callback)) {}

  /// False: stop. The callback stops the work by returning False or by raising.
  template <class... Args>
  bool goes_on(const Args&... args) {
    const auto now = std::chrono::steady_clock::now();
    const bool due = now - asked_ > std::chrono::milliseconds(50);
    if (callback_.is_none() && !due) return true;
    asked_ = now;
    const py::gil_scoped_acquire acquire;
    try {
      if (due && PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (callback_.is_none()) return true;
      const py::object answer = callback_(args...);
      const bool says = py::isinstance<py::bool_>(answer) ||
                        std::string_view(Py_TYPE(answer.ptr())->tp_name).starts_with("numpy.bool");
      return !says || answer.cast<bool>();
    } catch (...) {
      raised_ = std::current_exception();
      return false;
    }
  }
  /// For work that an exception stops: throws Stop instead of returning false.
  struct Stop {};
  template <class... Args>
  void go_on(const Args&... args) {
    if (!goes_on(args...)) throw Stop();
  }
  /// After the work: raises what stopped it.
  void raise() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  py::object callback_;
  std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
  std::exception_ptr raised_;
};

/// `released` for work that Watch::go_on may stop.
template <class Work>
auto released(Watch& watch, Work&& work) {
  try {
    return released(std::forward<Work>(work));
  } catch (const Watch::Stop&) {
    watch.raise();
    throw Failure({"", "stopped by its callback", Error::Kind::failure});
  }
}

/// A NumPy array on memory that `owner` keeps; no copy. Strides in bytes.
template <class T>
py::array view(const T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
               py::handle owner, bool writeable = false) {
  py::array out(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
  if (!writeable) py::detail::array_proxy(out.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return out;
}

/// The same of a matrix (2 dimensions) or vector (1) of Eigen.
template <class Dense>
py::array view(const Eigen::PlainObjectBase<Dense>& m, py::handle owner, bool writeable = false) {
  constexpr py::ssize_t size = sizeof(double);
  if constexpr (Dense::IsVectorAtCompileTime) return view(m.data(), {m.size()}, {size}, owner, writeable);
  return view(m.data(), {m.rows(), m.cols()}, {size * m.rowStride(), size * m.colStride()}, owner, writeable);
}
inline py::array view(const std::vector<double>& v, py::handle owner) {
  return view(v.data(), {py::ssize_t(v.size())}, {py::ssize_t(sizeof(double))}, owner);
}

/// A property's getter: a view of a member of class C, kept alive by the object.
template <class C, class Member>
auto view_of(Member C::*member) {
  return [member](const py::object& self) { return view(self.cast<const C&>().*member, self); };
}

/// A new array with a vector's or matrix's numbers.
template <class Dense>
py::array copy(const Eigen::PlainObjectBase<Dense>& m) {
  return view(m, py::none(), true).attr("copy")();
}

/// The object of class C that Python gives; a TypeError that says `expected` if it is another's.
template <class C>
C& object_of(const py::object& given, const char* expected) {
  if (!py::isinstance<C>(given)) throw py::type_error(std::string("expected ") + expected);
  return given.cast<C&>();
}

/// Numbers from anything that NumPy takes for an array of doubles.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The same of any object; `what` names it in the error.
Numbers numbers_of(const py::object& given, const std::string& what);
/// Numbers as a vector of `size`; `what` names them in the error.
Eigen::VectorXd vector_of(const Numbers& numbers, Eigen::Index size, const std::string& what);
/// An empty vector where None is given.
Eigen::VectorXd optional_vector(const py::object& numbers, Eigen::Index size, const std::string& what);

/// A page that stands on its own, in a frame within a notebook.
std::string framed(const std::string& page, int height);
/// A table in HTML: one list of cells per row, the first is the head.
std::string html_table(const std::vector<std::vector<std::string>>& rows, const std::string& caption = "");

/// Gives each sentence as a Python warning (borelli.DoubtWarning).
void warn(const std::vector<std::string>& sentences);

/// A path as text: str, bytes or os.PathLike.
std::string path_of(const py::object& path);

void add_scene(py::module_& module);
void add_equations(py::module_& module);
void add_batches(py::module_& module);
void add_simulation(py::module_& module);
void add_charts(py::module_& module);
void add_volumes(py::module_& module);
void add_segmentation(py::module_& module);
void add_tables(py::module_& module);

}  // namespace borelli::python
