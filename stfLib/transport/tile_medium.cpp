// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/tile_medium.h"

#include "stfLib/optics/fresnel.h"

namespace stf {

namespace {

// Voxels that the surface cuts may have been left empty by their maker, with their middle outside: they are made of
// what lies next to them inside.
void fillFromInside(BaseVolume& v, const std::vector<float>& fill) {
    const BaseVolume source = v;
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < v.size.x; ++x) {
                const std::size_t i = v.index(x, y, z);
                if (!(fill[i] > 0) || source.surface[i] < 0 || maxComponent(source.extinction[i]) > 0) {
                    continue;
                }
                std::size_t best = i;
                for (int c = 0; c < 27; ++c) {
                    const int nz = z + c / 9 - 1;
                    if (nz < 0 || nz >= v.size.z) {
                        continue;
                    }
                    const std::size_t n = v.index(TileTracer::wrap(x + c % 3 - 1, v.size.x),
                                                  TileTracer::wrap(y + c / 3 % 3 - 1, v.size.y), nz);
                    if (source.surface[n] < source.surface[best]) {
                        best = n;
                    }
                }
                v.extinction[i] = source.extinction[best];
                v.albedo[i] = source.albedo[best];
                if (!v.g.empty()) {
                    v.g[i] = source.g[best];
                }
                if (!v.ior.empty()) {
                    v.ior[i] = source.ior[best];
                }
                if (!v.emission.empty()) {
                    v.emission[i] = source.emission[best];
                }
            }
        }
    }
}

} // namespace

TileMedium::TileMedium(const BaseVolume& volume, TransportForm form, bool openBottom)
    : size_(volume.size), voxelMm_(volume.voxelMm), form_(form), openBottom_(openBottom),
      surface_(volume.size, volume.voxelMm, volume.surface) {
    BaseVolume prepared;
    const BaseVolume* v = &volume;
    if (hasSurface()) {
        fill_ = surface_.fill();
        prepared = volume;
        fillFromInside(prepared, fill_);
        v = &prepared;
    }
    const std::size_t n = v->voxelCount();
    voxels_.resize(n);
    collisions_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const float g = v->g.empty() ? 0.0f : v->g[i];
        const DeltaScale s = deltaScale(form, g);
        Voxel& o = voxels_[i];
        o.extinction = fill(i) > 0 ? scaledExtinction(v->extinction[i], v->albedo[i], s) : Rgb(0.0f);
        o.scattering = fill(i) > 0 ? v->extinction[i] * v->albedo[i] : Rgb(0.0f);
        o.g = g;
        o.gScaled = form == TransportForm::Classic ? 0.0f : s.g;
        o.keep = s.keep;
        collisions_[i] = {scaledCoalbedo(v->albedo[i], s), s.g};
        const Rgb& k = o.extinction;
        grey_ = grey_ && k.x == k.y && k.y == k.z;
        const bool scatters = maxComponent(o.scattering) > 0;
        scatters_ = scatters_ || scatters;
        flux_ = flux_ || (scatters && o.gScaled != 0);
    }
    for (int c = 1; c < 3; ++c) {
        for (int earlier = 0; earlier < c && like_[c] == c; ++earlier) {
            bool same = true;
            for (std::size_t i = 0; i < n && same; ++i) {
                same = voxels_[i].extinction[c] == voxels_[i].extinction[earlier] &&
                       collisions_[i].coalbedo[c] == collisions_[i].coalbedo[earlier] &&
                       (v->emission.empty() || v->emission[i][c] == v->emission[i][earlier]);
            }
            like_[c] = same ? earlier : c;
        }
    }
    for (int c = 0; c < (grey_ ? 1 : 3); ++c) {
        extinction_[c].reserve(n);
        for (const Voxel& o : voxels_) {
            extinction_[c].push_back(o.extinction[c]);
        }
    }

    // The index of voxels without material does not matter: no interface belongs to them.
    bool first = true, uniform = true;
    for (std::size_t i = 0; i < v->ior.size(); ++i) {
        if (fill(i) > 0) {
            refracts_ = refracts_ || v->ior[i] != 1;
            uniform = uniform && (first || v->ior[i] == uniformIor_);
            uniformIor_ = first ? v->ior[i] : uniformIor_;
            first = false;
        }
    }
    if (!uniform) {
        ior_ = v->ior;
    }
    for (std::size_t i = 0; i < v->emission.size(); ++i) {
        if (fill(i) > 0 && maxComponent(v->emission[i]) > 0) {
            emission_ = v->emission;
            break;
        }
    }
}

float TileMedium::ior(const Vec3f& p) const {
    if (ior_.empty()) {
        return uniformIor_;
    }
    const int x = TileTracer::wrap(int(std::floor(p.x)), size_.x), y = TileTracer::wrap(int(std::floor(p.y)), size_.y);
    const int z = std::clamp(int(std::floor(p.z)), 0, size_.z - 1);
    return ior_[std::size_t(x) + std::size_t(size_.x) * (std::size_t(y) + std::size_t(size_.y) * std::size_t(z))];
}

float TileMedium::topIor() const {
    if (hasSurface() || !refracts_) {
        return 1;
    }
    if (ior_.empty()) {
        return std::max(1.0f, uniformIor_);
    }
    const std::size_t columns = std::size_t(size_.x) * std::size_t(size_.y);
    double sum = 0;
    for (std::size_t i = 0; i < columns; ++i) {
        sum += double(ior_[i]);
    }
    return std::max(1.0f, float(sum / double(columns)));
}

Rgb TileMedium::opticalDepth(const Vec3f& position, const Vec3f& towards) const {
    Rgb depth(0.0f);
    const Vec3f d{float(towards.x / voxelMm_.x), float(towards.y / voxelMm_.y), float(-towards.z / voxelMm_.z)};
    const float endless = 1e5f * float(voxelMm_.z * size_.z);
    traverse(position, d, endless, [&](int voxel, float t0, float t1) {
        for (int c = 0; c < 3; ++c) {
            depth[c] += extinction_[grey_ ? 0 : c][std::size_t(voxel)] * (t1 - t0);
        }
        return true;
    });
    return depth;
}

TileMedium::FlatEntry TileMedium::enterFlat(const Vec3f& position, const Vec3f& towardsLight) const {
    // The index is that of the voxel where the light enters, which a varying index makes depend on the direction
    // inside: two rounds find it where neighbours differ little.
    FlatEntry in{0, 1, towardsLight};
    float n = ior_.empty() ? uniformIor_ : ior({position.x, position.y, 0});
    for (int round = 0; round < (ior_.empty() ? 1 : 2); ++round) {
        const FresnelSplit split = fresnel(towardsLight.z, n);
        in = {split.cosT, split.reflectance, {towardsLight.x / n, towardsLight.y / n, split.cosT}};
        const float way = position.z * float(voxelMm_.z) / std::max(split.cosT, 1e-6f);
        n = ior({position.x + in.towards.x * way / float(voxelMm_.x),
                 position.y + in.towards.y * way / float(voxelMm_.y), 0});
    }
    if (in.cosT > 0) {
        in.towards = normalize(in.towards);
    }
    return in;
}

} // namespace stf
