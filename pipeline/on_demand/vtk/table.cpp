#include "pipeline/on_demand/vtk/functions.hpp"
#include "process/on_demand.hpp"

namespace by_vtk = borelli::by_vtk;

BORELLI_ON_DEMAND(borelli::VtkFunctions){.smooth_surface = by_vtk::smooth_surface,
                                         .add_form = by_vtk::add_form,
                                         .write_vtp = by_vtk::write_vtp,
                                         .read_vtp = by_vtk::read_vtp,
                                         .draw_body = by_vtk::draw_body,
                                         .can_draw = by_vtk::can_draw,
                                         .draw_film = by_vtk::draw_film};
