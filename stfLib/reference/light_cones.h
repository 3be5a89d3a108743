// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <array>

namespace stf {

/// Directions inside a medium in which light is likely to come through its refracting surface: cones around where a
/// flat surface would bend it to. A density to choose directions from, nothing more: any surface will do. Each cone is
/// one around the light's own width and one wide enough for a surface that is turned elsewhere.
class LightCones {
public:
    void clear() { count_ = 0; }
    bool empty() const { return count_ == 0; }
    /// `towards`: of the light, unit, outside; `normal`: of the surface, unit, outward; `cosHalf`: of the light's half
    /// angle. Lights below the surface are left out, as are those for which there is no room.
    void add(const Vec3f& towards, const Vec3f& normal, float ior, float cosHalf);
    /// Unit direction towards the light.
    Vec3f sample(float pick, float u1, float u2) const;
    /// Per solid angle.
    float density(const Vec3f& towards) const;

private:
    static constexpr int kMost = 16;
    struct Cone {
        Vec3f axis;
        float cosHalf = 1;
    };
    std::array<Cone, kMost> cones_;
    int count_ = 0;
};

} // namespace stf
