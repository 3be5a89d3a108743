// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/synthesis_sheet.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/surface/ray_scene.h"
#include "tools/stfrecord/image.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr int kPanel = 720; ///< pixels along an edge of a picture
constexpr int kColumns = 3;
constexpr int kSubpixels = 2; ///< along each axis

struct View {
    Vec3d towards; ///< unit, to the viewer
    Vec3d right, up;
    Vec3d centre;
    double width = 1; ///< object units across the picture
    enum Kind { Patches, Coordinates, Material } kind = Material;
};

View viewFrom(const Vec3d& towards, const Box3f& bounds, double share, View::Kind kind) {
    View v;
    v.towards = normalize(towards);
    v.right = normalize(cross(Vec3d(0, 1, 0), v.towards));
    v.up = cross(v.towards, v.right);
    v.centre = (Vec3d(bounds.lo) + Vec3d(bounds.hi)) * 0.5;
    v.width = double(bounds.diagonal()) * share;
    v.kind = kind;
    return v;
}

class Painter {
public:
    Painter(const RefinedSurface& surface, const Synthesis& s, const ExemplarMap& map)
        : surface_(surface), s_(s), map_(map), mesh_(surface.points, surface.triangles) {
        int count = 0;
        patch_ = patchNumbers(s, count);
        const auto found = std::find(s.exemplar.parameterNames.begin(), s.exemplar.parameterNames.end(), "height");
        if (found != s.exemplar.parameterNames.end()) {
            height_ = &s.exemplar.parameters[std::size_t(found - s.exemplar.parameterNames.begin())];
        }
        float brightest = 0;
        for (const Rgb& r : s.exemplar.response) {
            brightest = std::max(brightest, maxComponent(r));
        }
        exposure_ = brightest > 0 ? 0.9f / brightest : 1;
    }

    void paint(const View& view, int column, int row, stfrecord::Image& image) const {
        const double far = 4 * double(surface_.bounds.diagonal());
        parallelFor(std::size_t(kPanel), 8, [&](std::size_t begin, std::size_t end) {
            for (int y = int(begin); y < int(end); ++y) {
                for (int x = 0; x < kPanel; ++x) {
                    Rgb sum(0.0f);
                    for (int k = 0; k < kSubpixels * kSubpixels; ++k) {
                        const double px = (x + (k % kSubpixels + 0.5) / kSubpixels) / kPanel - 0.5;
                        const double py = 0.5 - (y + (k / kSubpixels + 0.5) / kSubpixels) / kPanel;
                        Ray ray;
                        ray.origin = Vec3f(view.centre + (view.right * px + view.up * py) * view.width +
                                           view.towards * (0.5 * far));
                        ray.direction = Vec3f(-view.towards);
                        ray.tFar = float(far);
                        RayHit hit;
                        sum += mesh_.intersect(ray, hit, 1) ? colour(view, hit) : Rgb(0.05f);
                    }
                    const std::size_t at =
                        std::size_t(row * kPanel + y) * std::size_t(image.width) + std::size_t(column * kPanel + x);
                    for (int c = 0; c < 3; ++c) {
                        image.layers[0].floats[4 * at + std::size_t(c)] = sum[c] / float(kSubpixels * kSubpixels);
                    }
                    image.layers[0].floats[4 * at + 3] = 1;
                }
            }
        });
    }

private:
    template<class T>
    T blend(const std::vector<T>& values, std::size_t first, const RayHit& hit) const {
        return values[first] * (1 - hit.u - hit.v) + values[first + 1] * hit.u + values[first + 2] * hit.v;
    }

    Rgb colour(const View& view, const RayHit& hit) const {
        const std::size_t t = hit.triangle;
        const Vec3i& tri = surface_.triangles[t];
        Vec3d n = normalize(Vec3d(surface_.normals[std::size_t(tri.x)]) * double(1 - hit.u - hit.v) +
                            Vec3d(surface_.normals[std::size_t(tri.y)]) * double(hit.u) +
                            Vec3d(surface_.normals[std::size_t(tri.z)]) * double(hit.v));
        if (!surface_.cornerNormals.empty()) {
            n = normalize(Vec3d(blend(surface_.cornerNormals, 3 * t, hit)));
        }
        const Vec2f mm = blend(map_.cornerCoords, 3 * t, hit);
        if (view.kind == View::Patches) {
            // The patch of the nearest corner, in a colour of its own.
            const float b[3] = {1 - hit.u - hit.v, hit.u, hit.v};
            const int c = b[0] >= b[1] && b[0] >= b[2] ? 0 : b[1] >= b[2] ? 1 : 2;
            const std::uint32_t h = hash32(7, std::uint64_t(patch_[std::size_t(s_.graph.triangles[t][c])]));
            return Rgb(float(h & 255), float(h >> 8 & 255), float(h >> 16 & 255)) * (0.75f / 255) *
                       float(0.3 + 0.7 * std::abs(dot(n, view.towards))) +
                   Rgb(0.08f);
        }
        const Vec2f tile{float(map_.tileMm.x), float(map_.tileMm.y)};
        const float u = mm.x / tile.x - std::floor(mm.x / tile.x), v = mm.y / tile.y - std::floor(mm.y / tile.y);
        if (view.kind == View::Coordinates) {
            return Rgb(u, v, 0.25f) * float(0.3 + 0.7 * std::abs(dot(n, view.towards)));
        }
        const Exemplar& e = s_.exemplar;
        const auto sample = [&](const auto& values, float x, float y) {
            const float fx = std::floor(x - 0.5f), fy = std::floor(y - 0.5f), a = x - 0.5f - fx, b = y - 0.5f - fy;
            const auto at = [&](int dx, int dy) {
                return values[std::size_t(e.wrapY(int(fy) + dy)) * std::size_t(e.width) +
                              std::size_t(e.wrapX(int(fx) + dx))];
            };
            return at(0, 0) * ((1 - a) * (1 - b)) + at(1, 0) * (a * (1 - b)) + at(0, 1) * ((1 - a) * b) +
                   at(1, 1) * (a * b);
        };
        const float x = u * float(e.width), y = v * float(e.height);
        const Rgb albedo = sample(e.response, x, y);
        if (height_) {
            // Slopes of the relief tilt the normal.
            const Vec3d gx(blend(map_.gradientX, 3 * t, hit)), gy(blend(map_.gradientY, 3 * t, hit));
            const double sx = double(sample(*height_, x + 0.5f, y) - sample(*height_, x - 0.5f, y)) / e.texelMm.x;
            const double sy = double(sample(*height_, x, y + 0.5f) - sample(*height_, x, y - 0.5f)) / e.texelMm.y;
            n = normalize(n - (gx * sx + gy * sy) / s_.mmPerUnit);
        }
        const Vec3d light = normalize(view.towards * 0.6 + view.up * 0.6 - view.right * 0.5);
        const double diffuse = 0.15 + 0.85 * std::max(0.0, dot(n, light));
        return albedo * (exposure_ * float(diffuse));
    }

    const RefinedSurface& surface_;
    const Synthesis& s_;
    const ExemplarMap& map_;
    RayMesh mesh_;
    std::vector<int> patch_;
    const std::vector<float>* height_ = nullptr;
    float exposure_ = 1;
};

} // namespace

void writeSynthesisSheet(const RefinedSurface& surface, const Synthesis& synthesis, const ExemplarMap& map,
                         const std::string& path) {
    stfrecord::Image image;
    image.width = kColumns * kPanel;
    image.height = 2 * kPanel;
    image.layers.push_back(
        {"color", 4, std::vector<float>(4 * std::size_t(image.width) * std::size_t(image.height)), {}});
    const Painter painter(surface, synthesis, map);
    const Vec3d front(0.25, 0.3, 1), back(-0.4, 0.25, -1);
    painter.paint(viewFrom(front, surface.bounds, 0.72, View::Patches), 0, 0, image);
    painter.paint(viewFrom(front, surface.bounds, 0.72, View::Coordinates), 1, 0, image);
    painter.paint(viewFrom(front, surface.bounds, 0.72, View::Material), 2, 0, image);
    painter.paint(viewFrom(back, surface.bounds, 0.72, View::Material), 0, 1, image);
    View close = viewFrom(front, surface.bounds, 0.28, View::Material);
    painter.paint(close, 1, 1, image);
    close.centre += close.up * (0.18 * double(surface.bounds.diagonal())) -
                    close.right * (0.12 * double(surface.bounds.diagonal()));
    close.width *= 0.7;
    painter.paint(close, 2, 1, image);
    try {
        stfrecord::writePng(image, path);
    } catch (const std::exception& e) {
        throw Error(e.what());
    }
}

} // namespace stf
