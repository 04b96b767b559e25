/* A depth image as the semantic map sees it. */
#ifndef RFNAV_OBJECTS_VIEW_H
#define RFNAV_OBJECTS_VIEW_H

#include "objects.h"
#include "windows.h"

/* What is what, m and shares; `depth_segments.py` explains each. */
typedef struct {
    double edge_m, edge_share, floor_m, ceiling_m;
    double known_share, core_share, quantile, within_share, span_share;
    double cluster_m, before_share, before_m;
    double least_points, rim; /* one in so many of a thing's points is a stray at its rim */
    Strays strays;
} SegmentRules;
enum { SEGMENT_RULES = sizeof(SegmentRules) / sizeof(double) };

/* Of the camera in the base's frame, and of the base in the map's. */
typedef struct {
    double camera_x, camera_y, camera_z, x, y, cos, sin;
} Place;
enum { PLACE = sizeof(Place) / sizeof(double) };

/* A depth image, every n-th pixel of it. */
typedef struct {
    const SegmentRules *rules;
    Place place;
    Frame frame;
    Grid forward, left, up; /* of each pixel's ray, m per metre of depth */
    float *depth;           /* m, 0 for unknown */
    float *standing;        /* the same where a thing may be, not floor nor ceiling; else -inf */
    Surfaces surfaces;
    Region *within;   /* by label: of the box that is looked at */
    int32_t *touched; /* the labels that have one */
    int32_t *wanted;  /* by label, in which box it hangs together with the thing */
    double *numbers;  /* 5 of each pixel */
    void *memory;
} View;

/* Looks at every n-th pixel of a depth image, whose rays the view has. Returns what is wrong, or
 * NULL; its memory is to be freed either way. */
const char *view_open(View *view, const Grid *depth_m, Py_ssize_t stride);
/* How far away the thing in a box is, m; 0 where too little depth is known. */
float distance(View *view, Box box);

#endif
