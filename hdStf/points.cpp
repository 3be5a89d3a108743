// SPDX-License-Identifier: Apache-2.0
#include "hdStf/points.h"

#include "hdStf/conversions.h"
#include "stfLib/surface/point_set.h"

PXR_NAMESPACE_OPEN_SCOPE

stf::ControlMesh HdStfPoints::_Tessellate(std::string* problems) const {
    stf::PointSet set;
    set.points = HdStfToVector(_points);
    set.widths = HdStfToVector(_widths.values);
    set.colors = HdStfToVector(_colors.values);
    stf::PointRepairs repairs;
    stf::ControlMesh mesh = stf::tessellate(set, _refineLevel, _maxTriangles, repairs);
    *problems = repairs.summary();
    return mesh;
}

PXR_NAMESPACE_CLOSE_SCOPE
