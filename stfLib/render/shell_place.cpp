// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_place.h"

#include <algorithm>
#include <cmath>

namespace stf {

TileFrame::TileFrame(const ShellLookup& at) : normal_(at.normal) {
    tangent_ = normalize(at.gradX - normal_ * dot(at.gradX, normal_));
    bitangent_ = cross(normal_, tangent_);
    if (dot(bitangent_, at.gradY) < 0) {
        bitangent_ = -bitangent_;
    }
}

TileLights::TileLights(const ShellLight* lights, int count) : lights_(lights), count_(std::min(count, kMost)) {
    for (int l = 0; l < count_; ++l) {
        tile_[l].forSingle = lights[l].forSingle;
        tile_[l].forMultiple = lights[l].forMultiple;
    }
}

void TileLights::setFrame(const ShellLookup& at, const Vec3f& direction, TileMarch& tile) {
    const TileFrame frame(at);
    for (int l = 0; l < count_; ++l) {
        tile_[l].towards = frame.toTile(lights_[l].towards);
    }
    tile.setFrame(tile_, count_, frame.toTile(-direction));
}

bool ShellPlace::find(ShellProbe& probe, const Vec3f& p, const Rgb* core, int level) {
    ShellLookup found;
    if (!probe.lookup(p, found, core, level)) {
        return false;
    }
    at = found;
    at.depth -= entryDepth;
    point = p;
    return true;
}

void ShellPlace::enterHere(const Vec3f& direction, float back, float step, float mmPerUnit) {
    const float found = at.depth + dot(at.normal, direction) * mmPerUnit * back;
    // More than interpolation can be off by: the first lookup lies round a corner, below another face.
    entryDepth = std::abs(found) < 0.1f * step * mmPerUnit ? found : 0.0f;
    at.depth -= entryDepth;
}

void ShellPlace::carry(const Vec3f& direction, float distance, float mmPerUnit) {
    at.exemplar = at.exemplar + Vec2f(dot(at.gradX, direction), dot(at.gradY, direction)) * distance;
    at.depth -= dot(at.normal, direction) * mmPerUnit * distance;
    point += direction * distance;
}

TileLine ShellPlace::lineAlong(const Vec3f& direction, float back, const Vec3f& perMm, float mmPerUnit) const {
    // Voxels per millimetre of the way, from gradients in millimetres per object unit.
    const Vec3f along{dot(at.gradX, direction) * perMm.x / mmPerUnit, dot(at.gradY, direction) * perMm.y / mmPerUnit,
                      -dot(at.normal, direction) * perMm.z};
    const Vec3f here{at.exemplar.x * perMm.x, at.exemplar.y * perMm.y, at.depth * perMm.z};
    return {here - along * (back * mmPerUnit), along};
}

Vec3f ShellPlace::tilePosition(const Vec3f& p, const Vec3f& perMm, float mmPerUnit) const {
    const Vec3f d = p - point;
    return {(at.exemplar.x + dot(at.gradX, d)) * perMm.x, (at.exemplar.y + dot(at.gradY, d)) * perMm.y,
            (at.depth - dot(at.normal, d) * mmPerUnit) * perMm.z};
}

Vec3f ShellPlace::normalOf(const Vec3f& n, float mmPerUnit) const {
    return normalize(at.gradX * n.x + at.gradY * n.y + at.normal * (n.z * mmPerUnit));
}

} // namespace stf
