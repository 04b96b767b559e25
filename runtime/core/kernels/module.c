/* The compiled part of the core: what a frame costs most. Nothing here keeps anything from call to
 * call, and each kernel lets other threads run while it computes. */
#include "kernels.h"

static PyMethodDef methods[] = {
    {"march", (PyCFunction)(void (*)(void))kernel_march, METH_FASTCALL, NULL},
    {"descend", (PyCFunction)(void (*)(void))kernel_descend, METH_FASTCALL, NULL},
    {"boundary", (PyCFunction)(void (*)(void))kernel_boundary, METH_FASTCALL, NULL},
    {"components", (PyCFunction)(void (*)(void))kernel_components, METH_FASTCALL, NULL},
    {"derive", (PyCFunction)(void (*)(void))kernel_derive, METH_FASTCALL, NULL},
    {"integrate", (PyCFunction)(void (*)(void))kernel_integrate, METH_FASTCALL, NULL},
    {"in_sight", (PyCFunction)(void (*)(void))kernel_in_sight, METH_FASTCALL, NULL},
    {"means", (PyCFunction)(void (*)(void))kernel_means, METH_FASTCALL, NULL},
    {"near_points", (PyCFunction)(void (*)(void))kernel_near_points, METH_FASTCALL, NULL},
    {"nearest", (PyCFunction)(void (*)(void))kernel_nearest, METH_FASTCALL, NULL},
    {"register_depth", (PyCFunction)(void (*)(void))kernel_register_depth, METH_FASTCALL, NULL},
    {"see_through", (PyCFunction)(void (*)(void))kernel_see_through, METH_FASTCALL, NULL},
    {"shared", (PyCFunction)(void (*)(void))kernel_shared, METH_FASTCALL, NULL},
    {"solid", (PyCFunction)(void (*)(void))kernel_solid, METH_FASTCALL, NULL},
    {"steps_clear", (PyCFunction)(void (*)(void))kernel_steps_clear, METH_FASTCALL, NULL},
    {"survey", (PyCFunction)(void (*)(void))kernel_survey, METH_FASTCALL, NULL},
    {"reach_things", (PyCFunction)(void (*)(void))kernel_reach_things, METH_FASTCALL, NULL},
    {"touched", (PyCFunction)(void (*)(void))kernel_touched, METH_FASTCALL, NULL},
    {"walk", (PyCFunction)(void (*)(void))kernel_walk, METH_FASTCALL, NULL},
    {"whole_steps", (PyCFunction)(void (*)(void))kernel_whole_steps, METH_FASTCALL, NULL},
    {"things", (PyCFunction)(void (*)(void))kernel_things, METH_FASTCALL, NULL},
    {"joined_cells", (PyCFunction)(void (*)(void))kernel_joined_cells, METH_FASTCALL, NULL},
    {"cells_gap", (PyCFunction)(void (*)(void))kernel_cells_gap, METH_FASTCALL, NULL},
    {"cells_extent", (PyCFunction)(void (*)(void))kernel_cells_extent, METH_FASTCALL, NULL},
    {"put_place", (PyCFunction)(void (*)(void))kernel_put_place, METH_FASTCALL, NULL},
    {"near_places", (PyCFunction)(void (*)(void))kernel_near_places, METH_FASTCALL, NULL},
    {"in_plain_view", (PyCFunction)(void (*)(void))kernel_in_plain_view, METH_FASTCALL, NULL},
    {"cosine", (PyCFunction)(void (*)(void))kernel_cosine, METH_FASTCALL, NULL},
    {"add_where", (PyCFunction)(void (*)(void))kernel_add_where, METH_FASTCALL, NULL},
    {"shortened", (PyCFunction)(void (*)(void))kernel_shortened, METH_FASTCALL, NULL},
    {"sharpness", (PyCFunction)(void (*)(void))kernel_sharpness, METH_FASTCALL, NULL},
    {"unpack_rvl", (PyCFunction)(void (*)(void))kernel_unpack_rvl, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef_Slot slots[] = {{0, NULL}};

static struct PyModuleDef definition = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "_compiled",
    .m_size = 0,
    .m_methods = methods,
    .m_slots = slots,
};

PyMODINIT_FUNC PyInit__compiled(void) { return PyModuleDef_Init(&definition); }
