/* The kernels, as the module has them. */
#ifndef RFNAV_KERNELS_H
#define RFNAV_KERNELS_H

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000 /* one wheel a machine type, for Python 3.11 and newer */
#include <Python.h>

/* The rows of the method table. */
PyObject *kernel_march(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_descend(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_boundary(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_components(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_derive(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_integrate(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_in_sight(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_means(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_near_points(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_nearest(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_register_depth(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_shared(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_see_through(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_solid(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_steps_clear(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_survey(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_reach_things(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_touched(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_walk(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_whole_steps(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_things(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_joined_cells(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_cells_gap(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_cells_extent(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_put_place(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_near_places(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_in_plain_view(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_cosine(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_add_where(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_shortened(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_sharpness(PyObject *module, PyObject *const *args, Py_ssize_t count);
PyObject *kernel_unpack_rvl(PyObject *module, PyObject *const *args, Py_ssize_t count);

#endif
