// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/render/light_set.h"
#include "stfLib/render/shell_object.h"

namespace stf {

/// Radiance that leaves the core of one instance (B / pi, tile units cancel), per point of its surface: lights shine
/// through the shell onto samples of the inner boundary, the core's balance is solved there, and the exitance gathered
/// at the points. Depends on lights, geometry and the instance's place, not on the camera. Deterministic.
/// `rounding`: world units that shadow rays are lifted by. Throws Cancelled.
std::vector<Rgb> coreRadiance(const ShellObject& object, const Transform& objectToWorld, const RayScene& scene,
                              const LightSet& lights, float rounding, std::uint64_t seed, Progress& progress);

/// A point of the surface moved by a random step of at most `radius` (object units) within the tangent plane and put
/// back onto the surface; the point itself where the step leaves it. Visibility for multiple scattering starts there.
Vec3f jitterOnSurface(const RayMesh& mesh, const Vec3f& point, const Vec3f& normal, float radius, Vec2f u);

} // namespace stf
