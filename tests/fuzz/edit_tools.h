// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "edits.h"

#include "pxr/base/vt/array.h"
#include "pxr/usd/usdGeom/mesh.h"

namespace fuzz {

/// Points and faces of a small mesh. Of each, the numbers of faces, points and corners are three: UsdImaging of 20.08
/// keeps interpolations that a primvar had before, and only the number of values tells which one holds.
struct Shape {
    std::string name;
    PXR_NS::VtVec3fArray points;
    PXR_NS::VtIntArray counts, indices;
};
Shape randomShape(Random& random);

/// A path below a parent that nothing has yet, or empty.
PXR_NS::SdfPath freePath(const Session& session, const char* parent, const char* prefix, Random& random);

void author(const PXR_NS::UsdGeomMesh& mesh, const Shape& shape);

/// A placement somewhere in front of the cameras.
PXR_NS::GfMatrix4d randomPlace(Random& random);

/// One matrix as the prim's transform.
void placeAt(const PXR_NS::UsdPrim& prim, const PXR_NS::GfMatrix4d& place, PXR_NS::UsdTimeCode time);

/// Sets an attribute, made where it is not there, now or at a time of its own; says so.
std::string setAttribute(const PXR_NS::UsdPrim& prim, const std::string& name, const PXR_NS::SdfValueTypeName& type,
                         const PXR_NS::VtValue& value, Random& random, bool mayVary = true);

/// A value for each of what the interpolation counts; now and then one too few.
int valueCount(const PXR_NS::UsdGeomMesh& mesh, const PXR_NS::TfToken& interpolation, Random& random);
PXR_NS::TfToken randomInterpolation(Random& random);

/// Any of those, or an invalid prim.
inline PXR_NS::UsdPrim anyOf(const std::vector<PXR_NS::UsdPrim>& prims, Random& random) {
    return prims.empty() ? PXR_NS::UsdPrim() : random.of(prims);
}

/// Whether native instances may share the prim: then it can be edited but not go. UsdImaging of 20.08 reads prims of a
/// prototype after they went, and ends the process.
bool isInstanced(const PXR_NS::UsdPrim& prim);
std::string removePrim(Session& session, const PXR_NS::UsdPrim& prim);
/// The same prim under another name, beside its old place.
std::string renamePrim(Session& session, const PXR_NS::UsdPrim& prim, Random& random);

} // namespace fuzz
