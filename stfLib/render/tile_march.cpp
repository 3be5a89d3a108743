// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/tile_march.h"

#include "stfLib/optics/phase.h"
#include "stfLib/optics/step_weights.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
/// Below this the rest of a path is decided by roulette.
constexpr float kRouletteBelow = 0.01f;
/// 1 - cosine of the angle by which a frame may turn before lights are folded again.
constexpr float kSameDirection = 1e-6f;
/// Added modulo 1 from step to step: multiples of the golden ratio spread evenly over [0, 1), however many.
constexpr float kGolden = 0.618034f;
/// Steps of a path that single scattering is taken at.
constexpr int kSinglePicks = 4;

const FactoredField* ifAny(const FactoredField& field) {
    return field.empty() ? nullptr : &field;
}

// Where the weight of a linear source in a step of optical depth x has its middle, as a share of the step: a source
// evaluated there is integrated exactly. 1/2 for thin steps, 1/x for thick ones. `transmittance` = exp(-x).
float stepCentroid(float x, float transmittance) {
    return x < 0.5f ? 0.5f - x * (1.0f / 12 - x * x * (1.0f / 720))
                    : 1 / x - (transmittance > 0 ? transmittance / (1 - transmittance) : 0.0f);
}

// How much of a slope is believed in a voxel of this optical depth. Voxels hold means; above one mean free path their
// differences say nothing about the inside of a voxel, least of all at the top, where fluence bends. Measured on the
// exact fluence of a slab of depth 16 (albedo .9 and .99, views at mu .2 to 1): against constant voxels, slopes cut the
// error of the exit radiance three- to sevenfold at a voxel's depth of 0.25, by a fifth to two thirds at 0.5, and make
// it larger at 2.
float slopeTrust(float depth) {
    return std::clamp(1.5f - depth, 0.0f, 1.0f);
}

bool sameDirection(const Vec3f& a, const Vec3f& b) {
    return dot(a, b) > 1 - kSameDirection;
}

float sum(const Rgb& c) {
    return c.x + c.y + c.z;
}

} // namespace

TileMarch::TileMarch(const TileMedium& medium, const StfTable& table, const HistogramBlend* blend)
    : medium_(medium), table_(table), blend_(blend), voxelHeightMm_(float(medium.voxelMm().z)) {
    if (medium.scatters()) {
        multiple_ = ifAny(table.multiple.get());
        single_ = ifAny(table.single.get());
        emitted_ = medium.emits() ? ifAny(table.emitted.get()) : nullptr;
    }
}

void TileMarch::begin(PixelSampler& sampler, Vec2f shift) {
    const Vec2f first = sampler.next2d(), second = sampler.next2d(), third = sampler.next2d();
    shift_ = {shift.x * (first.x - 0.5f), shift.y * (first.y - 0.5f)};
    offset_ = {second.x - 0.5f, second.y - 0.5f};
    slopePick_ = third.x;
    flightPick_ = third.y;
    pick_ = sampler.next2d();
    transmittance_ = Rgb(1.0f);
    sum_ = {};
    candidates_.clear();
    places_.clear();
    frame_ = 0;
    ended_ = framed_ = frameKept_ = false;
    place_ = {};
}

void TileMarch::setBlend(const BlendPlace& place) {
    place_ = place;
}

void TileMarch::setFrame(const MarchLight* lights, int count, const Vec3f& towardsViewer) {
    const Frame& now = frames_[frame_];
    bool same = framed_ && std::size_t(count) == now.lights.size() && sameDirection(now.viewer, towardsViewer);
    for (int l = 0; l < count && same; ++l) {
        const MarchLight &a = lights[l], &b = now.lights[std::size_t(l)];
        same = sameDirection(a.towards, b.towards) && a.forSingle == b.forSingle && a.forMultiple == b.forMultiple;
    }
    if (same) {
        return;
    }
    if (frameKept_) {
        frameKept_ = false;
        if (++frame_ == frames_.size()) {
            frames_.emplace_back();
        }
    }
    frames_[frame_].lights.assign(lights, lights + count);
    frames_[frame_].viewer = towardsViewer;
    framed_ = true;
    foldFrame();
}

void TileMarch::foldFrame() {
    const auto& [lights, viewer] = frames_[frame_];
    wantsSingle_ = false;
    for (const MarchLight& l : lights) {
        wantsSingle_ = wantsSingle_ || (maxComponent(l.forSingle) > 0 && l.towards.z > 0);
    }
    if (multiple_) {
        foldedLights_.clear(*multiple_);
        for (const MarchLight& l : lights) {
            if (maxComponent(l.forMultiple) > 0) {
                foldedLights_.add(*multiple_, table_.directions, l.towards, l.forMultiple, viewer);
            }
        }
    }
    if (single_) {
        foldedSingle_.resize(std::max(foldedSingle_.size(), lights.size()));
        const Vec3f axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (std::size_t l = 0; l < lights.size(); ++l) {
            for (std::size_t a = 0; a < 3; ++a) {
                foldedSingle_[l][a].clear(*single_);
                foldedSingle_[l][a].add(*single_, table_.directions, lights[l].towards, lights[l].forSingle, axes[a]);
            }
        }
    }
    foldOne(backlight_, foldedCore_);
    foldOne(emitted_, foldedEmission_);
}

// A field without light directions.
void TileMarch::foldOne(const FactoredField* field, FoldedLight& light) const {
    if (field) {
        light.clear(*field);
        light.add(*field, DirectionSet(1, 1), {0, 0, 1}, Rgb(1.0f), frames_[frame_].viewer);
    }
}

void TileMarch::openBacklight() {
    backlightOpen_ = true;
    backlight_ = medium_.scatters() ? ifAny(table_.backlight.get()) : nullptr;
    foldOne(backlight_, foldedCore_);
}

// Numbers of the columns that a point (voxel units) shows.
std::array<std::size_t, 3> TileMarch::columnsAt(const Vec3f& p, const BlendPlace& place) const {
    const Vec3i& size = medium_.size();
    const auto column = [&](float x, float y) {
        return std::size_t(TileTracer::wrap(int(std::floor(x)), size.x)) +
               std::size_t(size.x) * std::size_t(TileTracer::wrap(int(std::floor(y)), size.y));
    };
    std::array<std::size_t, 3> columns{column(p.x, p.y), 0, 0};
    for (std::size_t i = 0; i < 2; ++i) {
        if (place.weight[i + 1] > 0) {
            const Vec2f at = place.origin[i] + place.alongX[i] * p.x + place.alongY[i] * p.y;
            columns[i + 1] = column(at.x, at.y);
        }
    }
    return columns;
}

// A part of the table; blended, mean and variance of the layer are kept.
FieldValue TileMarch::read(const FactoredField& field, const FactoredField* means, const FoldedLight& light,
                           const Items& items) const {
    if (!blend_ || means->empty() || place_.weight[0] == 1) {
        return field.at(items.item[0], light);
    }
    const FieldValue mean = means->at(items.layer, light);
    const float gain = HistogramBlend::gain(place_);
    FieldValue v = mean;
    for (std::size_t i = 0; i < 3; ++i) {
        if (const float w = place_.weight[i] * gain; w > 0) {
            const FieldValue one = field.at(items.item[i], light);
            v.fluence += (one.fluence - mean.fluence) * w;
            v.fluxAlong += (one.fluxAlong - mean.fluxAlong) * w;
        }
    }
    for (int c = 0; c < 3; ++c) {
        v.fluence[c] = std::max(v.fluence[c], 0.0f);
    }
    return v;
}

FieldValue TileMarch::valueAt(const Items& items, const Rgb& coreRadiance) const {
    FieldValue v;
    if (multiple_ && !foldedLights_.dark()) {
        v = read(*multiple_, blend_ ? &blend_->meanMultiple() : nullptr, foldedLights_, items);
    }
    if (backlight_ && maxComponent(coreRadiance) > 0) {
        const FieldValue b = read(*backlight_, blend_ ? &blend_->meanBacklight() : nullptr, foldedCore_, items);
        v.fluence += coreRadiance * b.fluence;
        v.fluxAlong += coreRadiance * b.fluxAlong;
    }
    if (emitted_) {
        const FieldValue e = read(*emitted_, blend_ ? &blend_->meanEmitted() : nullptr, foldedEmission_, items);
        v.fluence += e.fluence;
        v.fluxAlong += e.fluxAlong;
    }
    return v;
}

// The field at a point of a voxel. Laterally the table is read with the path's offset. In depth it is linear within
// each voxel: the voxel's mean, which it keeps, and the slope of its neighbours (one-sided in the first and the last
// layer, where it is an extrapolation), after the piecewise linear method (van Leer 1979, "Towards the Ultimate
// Conservative Difference Scheme V"). Being linear, it does not depend on where a path is cut into steps.
// Most steps have their weight near the middle of a voxel and would read two more voxels for next to nothing: the slope
// is added with a chance that equals its share, full, except where it matters most.
FieldValue TileMarch::fieldAt(const Vec3f& p, const TileMedium::Voxel& voxel, std::size_t& item,
                              const Rgb& coreRadiance) {
    const Vec3i &size = medium_.size(), &tableSize = table_.size;
    int x = int(std::floor(p.x + offset_.x)), y = int(std::floor(p.y + offset_.y));
    const int z = std::clamp(int(p.z), 0, size.z - 1);
    // Beside the surface of a relief there may be no material to read from; there is at the point itself.
    const auto fill = [&](int layer) {
        return medium_.fill(std::size_t(TileTracer::wrap(x, size.x)) +
                            std::size_t(size.x) *
                                (std::size_t(TileTracer::wrap(y, size.y)) + std::size_t(size.y) * std::size_t(layer)));
    };
    const bool relief = medium_.hasSurface();
    if (relief && !(fill(z) > 0)) {
        x = int(std::floor(p.x));
        y = int(std::floor(p.y));
    }
    const std::size_t layer = std::size_t(tableSize.x) * std::size_t(tableSize.y);
    item = (layer > 1 ? std::size_t(TileTracer::wrap(x, tableSize.x)) +
                            std::size_t(tableSize.x) * std::size_t(TileTracer::wrap(y, tableSize.y))
                      : 0) +
           layer * std::size_t(z);
    Items items;
    items.item[0] = item;
    if (blend_) {
        items.layer = std::size_t(z);
        items.item = columnsAt({p.x + offset_.x, p.y + offset_.y, p.z}, place_);
        for (std::size_t& i : items.item) {
            i = (layer > 1 ? i : 0) + layer * std::size_t(z);
        }
    }
    FieldValue v = valueAt(items, coreRadiance);

    float along = (p.z - float(z) - 0.5f) * slopeTrust(average(voxel.extinction) * voxelHeightMm_);
    bool above = z > 0, below = z + 1 < size.z;
    if (above && below) {
        slopePick_ += kGolden;
        slopePick_ -= slopePick_ < 1 ? 0.0f : 1.0f;
        along = slopePick_ < std::abs(along) ? std::copysign(1.0f, along) : 0.0f;
    }
    if (relief && along != 0) {
        const bool whole = fill(z) >= 1;
        above = above && whole && fill(z - 1) >= 1;
        below = below && whole && fill(z + 1) >= 1;
    }
    if (along == 0 || !(above || below)) {
        return v;
    }
    const auto beside = [&](std::ptrdiff_t layers) {
        Items other = items;
        other.layer += std::size_t(layers);
        for (std::size_t& i : other.item) {
            i += std::size_t(layers) * layer;
        }
        return valueAt(other, coreRadiance);
    };
    const FieldValue up = above ? beside(-1) : v;
    const FieldValue down = below ? beside(1) : v;
    const float scale = above && below ? 0.5f : 1.0f;
    const Rgb slope = (down.fluence - up.fluence) * scale;
    // From 0 to twice the mean, from one face of the voxel to the other.
    float limit = 1;
    for (int c = 0; c < 3; ++c) {
        const float most = 2 * std::max(v.fluence[c], 0.0f);
        limit = std::abs(slope[c]) * limit > most ? most / std::abs(slope[c]) : limit;
    }
    v.fluence += slope * (along * limit);
    v.fluxAlong += (down.fluxAlong - up.fluxAlong) * (scale * along * limit);
    return v;
}

// In-scattered radiance of light before its first collision from the table: per light the phase function around the
// mean direction, widened as the directions are. A Henyey-Greenstein spread of mean cosine r = |F| / I, seen through
// the phase function g, is the one of g r: exact for parallel light and in the first moment for any.
Rgb TileMarch::storedSingle(std::size_t item, float g) const {
    const auto& [lights, viewer] = frames_[frame_];
    Rgb radiance(0.0f);
    for (std::size_t l = 0; l < lights.size(); ++l) {
        const AxisLight& axes = foldedSingle_[l];
        if (axes[0].dark()) {
            continue;
        }
        const FieldValue x = single_->at(item, axes[0]);
        Vec3f direction = -lights[l].towards; // without flux no voxel turns light one way more than another
        float concentration = 1;
        if (single_->hasFlux()) {
            const Vec3f flux{sum(x.fluxAlong), sum(single_->at(item, axes[1]).fluxAlong),
                             sum(single_->at(item, axes[2]).fluxAlong)};
            const float total = sum(x.fluence), net = length(flux);
            concentration = total > 0 ? std::min(1.0f, net / total) : 0.0f;
            direction = net > 0 ? flux / net : direction;
        }
        radiance += x.fluence * henyeyGreenstein(g * concentration, direction, viewer);
    }
    return radiance;
}

// One stretch of a straight piece within a voxel of the material. False once roulette has ended the path.
bool TileMarch::step(int index, const Vec3f& position, const Vec3f& perMm, float a, float b, const Rgb& coreRadiance) {
    const bool emits = medium_.emits(), candidates = wantsSingle_ && !single_;
    const bool field = multiple_ || emitted_ || backlight_, grey = medium_.greyExtinction();
    const float h = b - a;
    TileMedium::Voxel blended;
    if (blend_) {
        const Vec3f middle = position + perMm * (0.5f * (a + b));
        const std::size_t columns = std::size_t(medium_.size().x) * std::size_t(medium_.size().y);
        blended = blend_->voxel(columnsAt(middle, place_), place_, int(std::size_t(index) / columns));
    }
    const TileMedium::Voxel& m = blend_ ? blended : medium_.voxel(std::size_t(index));
    if (!(maxComponent(m.extinction) > 0)) {
        if (emits) {
            sum_.multiple += transmittance_ * medium_.emission(std::size_t(index)) * h;
        }
        return true;
    }
    const StepWeightsRgb w = stepWeights(m.extinction * h);
    const Rgb seen = transmittance_ * w.phi1 * h;
    if (emits) {
        sum_.multiple += seen * medium_.emission(std::size_t(index));
    }
    const Rgb scattered = seen * m.scattering;
    if (maxComponent(scattered) > 0) {
        if (field || single_) {
            const float x = grey ? m.extinction.x * h : average(m.extinction) * h;
            const float middle = stepCentroid(x, grey ? w.transmittance.x : std::exp(-x));
            std::size_t item = 0;
            FieldValue v = fieldAt(position + perMm * (a + middle * h), m, item, coreRadiance);
            if (m.gScaled != 0) {
                v.fluence += v.fluxAlong * (3 * m.gScaled);
            }
            sum_.multiple += scattered * v.fluence * (m.keep / (4 * kPi));
            if (single_ && wantsSingle_) {
                sum_.single += scattered * storedSingle(item, m.g);
            }
        }
        if (candidates) {
            offer(m, position + perMm * a, perMm, h, average(scattered));
        }
    }

    transmittance_ *= w.transmittance;
    if (maxComponent(transmittance_) < kRouletteBelow) {
        // Unbiased: survivors carry the weight of those that end here.
        if (pick_.y < 0.25f) {
            pick_.y *= 4;
            transmittance_ *= 4.0f;
        } else {
            pick_.y = (pick_.y - 0.25f) / 0.75f; // uniform again
            transmittance_ = Rgb(0.0f);
            ended_ = true;
            return false;
        }
    }
    return true;
}

Vec3f TileMarch::openSegment(const Vec3f& position, const Rgb& coreRadiance) {
    if (!backlightOpen_ && maxComponent(coreRadiance) > 0) {
        openBacklight();
    }
    return shifted(position);
}

// Facets and interpolation may start a ray a hair outside of the tile.
Vec3f TileMarch::shifted(const Vec3f& p) const {
    return {p.x + shift_.x, p.y + shift_.y, std::clamp(p.z, 0.0f, float(medium_.size().z))};
}

bool TileMarch::segment(Vec3f position, const Vec3f& perMm, float lengthMm, const Rgb& coreRadiance) {
    if (ended_) {
        return false;
    }
    position = openSegment(position, coreRadiance);
    medium_.traverse(position, perMm, lengthMm,
                     [&](int index, float a, float b) { return step(index, position, perMm, a, b, coreRadiance); });
    return !ended_;
}

bool TileMarch::insideRelief(const Vec3f& position) const {
    return !medium_.hasSurface() || medium_.surface().inside(shifted(position));
}

float TileMarch::iorAt(const Vec3f& position) const {
    return medium_.ior(shifted(position));
}

float TileMarch::iorBelow(const Vec3f& position) const {
    Vec3f p = shifted(position);
    while (p.z < float(medium_.size().z - 1) && !medium_.surface().inside(p)) {
        p.z += 1;
    }
    return medium_.ior(p);
}

TileMarch::Segment TileMarch::segmentToRelief(Vec3f position, const Vec3f& perMm, float lengthMm, bool inside,
                                              ReliefMeeting& met, const Rgb& coreRadiance) {
    if (ended_) {
        return Segment::Ended;
    }
    position = openSegment(position, coreRadiance);
    const SurfaceField& surface = medium_.surface();
    const auto normalAt = [&](const Vec3f& p) { return surface.normal(p); }; // z inward, as `perMm`
    const Vec3f mm(medium_.voxelMm());
    const Vec3f direction{perMm.x * mm.x, perMm.y * mm.y, perMm.z * mm.z};
    Segment result = Segment::Passed;
    TileTracer(medium_.size())
        .traverse(position, perMm, lengthMm, [&](int index, int x, int y, int z, float a, float b) {
            float end = b;
            bool meets = false;
            if (surface.crossedBySurface(std::size_t(index))) {
                const float t = surface.crossing({x, y, z}, position, perMm, a, b, inside);
                meets = t <= b;
                end = meets ? std::max(t, a) : b;
            } else if (surface.insideVoxel(std::size_t(index)) != inside) {
                // Between two pieces it was carried across. On its way back it has nothing to pass.
                const float along = dot(direction, normalAt(position + perMm * a));
                meets = inside ? along > 0 : along < 0;
                end = meets ? a : b;
            }
            if (inside && end > a && !step(index, position, perMm, a, end, coreRadiance)) {
                result = Segment::Ended;
                return false;
            }
            if (!meets) {
                return true;
            }
            const Vec3f at = position + perMm * end, facet = normalAt(at), smooth = surface.smoothNormal(at);
            met.atMm = end;
            met.facet = {facet.x, facet.y, -facet.z};
            met.normal = {smooth.x, smooth.y, -smooth.z};
            met.ior = medium_.ior(at - facet * 0.5f); // of the material, half a voxel inside, as for walks
            result = Segment::Met;
            return false;
        });
    return result;
}

void TileMarch::branch(const Rgb& transmittance) {
    transmittance_ = transmittance;
    sum_ = {};
    candidates_.clear();
    places_.clear();
    ended_ = frameKept_ = false;
}

void TileMarch::offer(const TileMedium::Voxel& m, const Vec3f& position, const Vec3f& perMm, float lengthMm,
                      float weight) {
    if (blend_) {
        places_.push_back(place_);
    }
    const float before = candidates_.empty() ? 0.0f : candidates_.back().upTo;
    candidates_.push_back({transmittance_, position, perMm, lengthMm, weight, before + weight, m.extinction,
                           m.scattering, m.g, std::uint32_t(frame_),
                           std::uint32_t(places_.empty() ? 0 : places_.size() - 1)});
    frameKept_ = true;
}

// A blend is the same all the way.
UncollidedLight TileMarch::uncollided(const Candidate& step, const Vec3f& p, const Vec3f& towards) const {
    if (!blend_) {
        return medium_.uncollided(p, towards);
    }
    const Vec3d& mm = medium_.voxelMm();
    const std::size_t columns = std::size_t(medium_.size().x) * std::size_t(medium_.size().y);
    const BlendPlace& place = places_[step.place];
    return medium_.uncollided(p, towards, [&](const Vec3f& from, const Vec3f& way) {
        Rgb depth(0.0f);
        const Vec3f d{float(way.x / mm.x), float(way.y / mm.y), float(-way.z / mm.z)};
        const float endless = 1e5f * float(mm.z * medium_.size().z);
        medium_.traverse(from, d, endless, [&](int index, float a, float b) {
            const Vec3f middle = from + d * (0.5f * (a + b));
            depth +=
                blend_->voxel(columnsAt(middle, place), place, int(std::size_t(index) / columns)).extinction * (b - a);
            return true;
        });
        return depth;
    });
}

// A point of a step by the free flight of one channel, weighted by the mean density of all three, so that no weight
// exceeds three whatever the channels' extinctions are (one-sample balance heuristic; Wilkie et al. 2014, "Hero
// Wavelength Spectral Sampling"). Single scattering has the true phase function and the light's own attenuation through
// the tile.
Rgb TileMarch::singleAt(const Candidate& c, float channel, float u) const {
    const float h = c.lengthMm;
    const auto density = [&](float k, float x) {
        return k * h > 1e-4f ? k * std::exp(-k * x) / -std::expm1(-k * h) : 1 / h;
    };
    const float kappa = c.extinction[std::min(2, int(channel * 3))];
    const float s = kappa * h > 1e-4f ? std::min(h, -std::log1p(u * std::expm1(-kappa * h)) / kappa) : u * h;
    const float mean = (density(c.extinction.x, s) + density(c.extinction.y, s) + density(c.extinction.z, s)) / 3;
    const Rgb path = c.transmittance * exp(-c.extinction * s) * c.scattering / std::max(mean, 1e-30f);
    const Vec3f p = c.position + c.perMm * s;
    const auto& [lights, viewer] = frames_[c.frame];
    Rgb single(0.0f);
    for (const MarchLight& l : lights) {
        if (!(l.towards.z > 0) || !(maxComponent(l.forSingle) > 0)) {
            continue;
        }
        const UncollidedLight light = uncollided(c, p, l.towards);
        single += path * l.forSingle * light.fraction * henyeyGreenstein(c.g, -light.towards, viewer);
        if (medium_.openBottom()) {
            const Vec3f up{-light.towards.x, -light.towards.y, light.towards.z};
            single += path * l.forSingle * light.reflected * henyeyGreenstein(c.g, up, viewer);
        }
    }
    return single;
}

// At steps in proportion to their weights, evenly spread along the path (systematic resampling, Kitagawa 1996).
Rgb TileMarch::chosenSingle() const {
    Rgb single(0.0f);
    if (candidates_.empty()) {
        return single;
    }
    const float all = candidates_.back().upTo;
    std::size_t at = 0;
    for (int i = 0; i < kSinglePicks; ++i) {
        const float wanted = (float(i) + pick_.x) * (all / float(kSinglePicks));
        while (at + 1 < candidates_.size() && candidates_[at].upTo <= wanted) {
            ++at;
        }
        const auto turned = [&](float u) { return u + float(i) * kGolden - std::floor(u + float(i) * kGolden); };
        const Candidate& c = candidates_[at];
        single += singleAt(c, turned(pick_.y), turned(flightPick_)) * (all / (c.weight * float(kSinglePicks)));
    }
    return single;
}

TileRadiance TileMarch::finish() {
    TileRadiance r = sum_;
    r.single += chosenSingle();
    return r;
}

} // namespace stf
