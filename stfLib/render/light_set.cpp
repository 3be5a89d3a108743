// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_set.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr int kMostLinks = 64; // one bit each
/// Half angle, degrees, from which on a distant light is seen in mirrors: a smaller disc would be met by so few paths
/// that it is noise.
constexpr double kMirroredDegrees = 2;

/// Of a disc of light of half angle `half`, at most a right angle.
double projectedSolidAngle(double half) {
    return double(kPi) * std::sin(half) * std::sin(half);
}

double halfAngle(const Light& distant) {
    return std::clamp(double(distant.angle), 0.0, 180.0) * double(kPi) / 360.0;
}

/// `emission` is that, or with an angle the radiance of the disc.
Rgb perpendicularIrradiance(const Light& distant) {
    const double half = halfAngle(distant);
    return distant.emission * (!distant.normalize && half > 0 ? float(projectedSolidAngle(half)) : 1.0f);
}

/// Of a direction in a distant light's disc, uniform in projected solid angle.
float distantDensity(float cosHalf, float cosine) {
    return cosine / (kPi * (1 - cosHalf * cosHalf));
}

Rgb pixelAt(const LatLongImage& image, const Vec2f& uv) {
    const float fx = uv.x * float(image.width) - 0.5f, fy = uv.y * float(image.height) - 0.5f;
    const int x = int(std::floor(fx)), y = int(std::floor(fy));
    const float ax = fx - float(x), ay = fy - float(y);
    const auto pixel = [&](int i, int j) {
        return image.at(std::clamp(i, 0, image.width - 1), std::clamp(j, 0, image.height - 1));
    };
    return (pixel(x, y) * (1 - ax) + pixel(x + 1, y) * ax) * (1 - ay) +
           (pixel(x, y + 1) * (1 - ax) + pixel(x + 1, y + 1) * ax) * ay;
}

} // namespace

LightSet::LightSet(const std::map<std::string, Light>& lights, const MessageSink& messages) {
    for (const auto& [id, light] : lights) {
        if (!light.visible || !(maxComponent(light.emission) > 0) || !isFinite(light.emission)) {
            if (!isFinite(light.emission)) {
                report(messages, Severity::Error, id + ": the light's intensity is not finite, it is left out");
            }
            continue;
        }
        if (!light.lightToWorld.invertible()) {
            report(messages, Severity::Error, id + ": the light's transform is singular, it is left out");
            continue;
        }
        Prepared p;
        p.type = light.type;
        p.light = light;
        p.emission = light.emission;
        p.shadows = light.shadows;
        p.lit = linkBit(id, light.lightLink, messages);
        p.shading = linkBit(id, light.shadowLink, messages);
        anyBehindThings_ = anyBehindThings_ || p.behindThings();
        linksShadows_ = linksShadows_ || (p.shadows && p.shading != 0);
        if (light.type == Light::Type::Dome) {
            p.dome = DomeLight(id, light, messages);
        } else if (light.type == Light::Type::Distant) {
            p.axis = Vec3f(normalize(light.lightToWorld.vector({0, 0, 1})));
            p.cosAngle = float(std::cos(halfAngle(light)));
            p.emission = perpendicularIrradiance(light);
        } else if (!prepareArea(id, p, messages)) {
            continue;
        }
        lights_.push_back(std::move(p));
    }
    hostLights_ = lights_.size();
    place(Vec3d(0.0));
}

std::uint64_t LightSet::linkBit(const std::string& id, const std::string& name, const MessageSink& messages) {
    if (name.empty()) {
        return 0;
    }
    const auto known = links_.find(name);
    if (known != links_.end()) {
        return known->second;
    }
    if (links_.size() == std::size_t(kMostLinks)) {
        report(messages, Severity::Error,
               id + ": there are more than " + std::to_string(kMostLinks) +
                   " collections that lights are linked by; it lights, or is shadowed by, everything");
        return 0;
    }
    return links_[name] = std::uint64_t(1) << links_.size();
}

std::uint64_t LightSet::linksOf(const std::vector<std::string>& names) const {
    std::uint64_t bits = 0;
    for (const std::string& name : names) {
        const auto it = links_.find(name);
        bits |= it == links_.end() ? 0 : it->second;
    }
    return bits;
}

void LightSet::widen(Light& light, float angle) {
    light.emission = perpendicularIrradiance(light);
    light.normalize = true;
    light.angle = angle;
}

bool LightSet::prepareArea(const std::string& id, Prepared& p, const MessageSink& messages) const {
    const std::optional<AreaShape> shape = AreaShape::make(p.light, p.light.lightToWorld);
    if (!shape) {
        report(messages, Severity::Error, id + ": the light has no area, it is left out");
        return false;
    }
    if (p.light.normalize) {
        p.emission = Rgb(Vec3d(p.emission) / shape->area());
    }
    p.shaping = ShapedEmission(id, p.light.shaping, messages);
    p.worldToLight = p.light.lightToWorld.inverse();
    if (p.type == Light::Type::Rect && !p.light.textureFile.empty()) {
        try {
            p.image = readLatLong(p.light.textureFile);
        } catch (const std::exception& e) {
            report(messages, Severity::Error, id + ": texture " + e.what() + "; the light is uniform");
        }
    }
    return true;
}

void LightSet::place(const Vec3d& origin, const std::vector<MeshEmitter>& meshes) {
    lights_.resize(hostLights_);
    emitters_.clear();
    for (const MeshEmitter& m : meshes) {
        Prepared p;
        p.mesh = std::make_shared<const MeshShape>(m.surface, m.objectToWorld);
        p.type = Light::Type::Rect; // one with an area
        p.emission = m.radiance;
        if (p.mesh->area() > 0 && std::isfinite(p.mesh->area())) {
            emitters_[m.instance] = lights_.size();
            lights_.push_back(std::move(p));
        }
    }
    far_.clear();
    std::vector<TreeLight> near;
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        Prepared& p = lights_[i];
        if (p.type == Light::Type::Dome || p.type == Light::Type::Distant) {
            far_.push_back(i);
            continue;
        }
        if (p.mesh) {
            near.push_back({p.mesh->bounds(), 2 * average(p.emission) * float(p.mesh->area()), i});
            continue;
        }
        Transform t = p.light.lightToWorld;
        t.translation -= origin;
        p.shape = *AreaShape::make(p.light, t); // as when it was prepared
        near.push_back({p.shape.bounds(), average(p.emission) * float(p.shape.area()), i});
    }
    areaCount_ = near.size();
    tree_ = LightTree(std::move(near));
}

int LightSet::choose(const Vec3f& point, const Vec3f& normal, float u, int most, LightPick* picks) const {
    if (lights_.size() <= std::size_t(most)) {
        for (std::size_t i = 0; i < lights_.size(); ++i) {
            picks[i] = {i, 1};
        }
        return int(lights_.size());
    }
    // Half for each kind where both are many.
    const int spare = std::max(most - int(std::min(areaCount_, std::size_t(most))), most / 2);
    const int far = int(std::min(far_.size(), std::size_t(spare)));
    int count = 0;
    for (int i = 0; i < far; ++i) {
        // A random start, then evenly through the list: all of them where there are enough picks.
        const std::size_t k = std::min(far_.size() - 1, std::size_t((float(i) + u) * float(far_.size()) / float(far)));
        picks[count++] = {far_[std::size_t(far) == far_.size() ? std::size_t(i) : k], float(far_.size()) / float(far)};
    }
    const int near = std::min(most - far, int(areaCount_));
    if (std::size_t(near) == areaCount_) {
        for (std::size_t i = 0; i < lights_.size(); ++i) {
            if (lights_[i].type != Light::Type::Dome && lights_[i].type != Light::Type::Distant) {
                picks[count++] = {i, 1};
            }
        }
        return count;
    }
    for (int i = 0; i < near; ++i) {
        const LightTree::Choice c = tree_.choose(point, normal, (float(i) + u) / float(near));
        if (c.chance > 0) {
            picks[count++] = {c.index, 1 / (c.chance * float(near))};
        }
    }
    return count;
}

// Radiance that leaves a light with an area along a direction (world, from the light) at a point of it.
Rgb LightSet::Prepared::radiance(const Vec3f& direction, const Vec3f& at) const {
    Rgb r = emission;
    if (!shaping.none()) {
        r *= shaping.factor(normalize(Vec3f(worldToLight.vector(Vec3d(direction)))));
    }
    if (!image.empty()) {
        r *= pixelAt(image, shape.textureAt(at));
    }
    return r;
}

LightSample LightSet::sample(std::size_t index, const Vec3f& point, const Vec3f& normal, Vec2f u) const {
    const Prepared& l = lights_[index];
    LightSample s;
    s.shadows = l.shadows;
    s.lit = l.lit;
    s.shading = l.shading;
    if (l.type == Light::Type::Dome) {
        s.irradiance = l.dome.sample(normal, u, s.towards, s.density);
    } else if (l.type == Light::Type::Distant) {
        // Uniform in projected solid angle: constant radiance, so the weight is the irradiance itself.
        s.towards = l.axis;
        s.irradiance = l.emission;
        if (l.cosAngle < 1) {
            Vec3f t, b;
            orthonormalBasis(l.axis, t, b);
            const float sin2 = u.x * (1 - l.cosAngle * l.cosAngle), r = std::sqrt(sin2), phi = 2 * kPi * u.y;
            s.towards = normalize(t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + l.axis * std::sqrt(1 - sin2));
            s.density = l.seenAlong() ? distantDensity(l.cosAngle, std::sqrt(1 - sin2)) : 0.0f;
        }
    } else {
        const ShapeSample at = l.mesh ? l.mesh->sample(point, u) : l.shape.sample(point, u);
        if (at.solidAngle > 0) {
            s.towards = at.towards;
            s.distance = at.distance;
            s.density = 1 / at.solidAngle;
            s.onMesh = l.mesh != nullptr;
            s.point = point + at.towards * at.distance;
            s.irradiance = l.radiance(-at.towards, s.point) * at.solidAngle;
        }
    }
    return s;
}

Rgb LightSet::background(const Vec3f& direction, std::uint64_t links) const {
    Rgb sum(0.0f);
    for (std::size_t i : far_) {
        if (lights_[i].type == Light::Type::Dome && lights_[i].reaches(links)) {
            sum += lights_[i].dome.radiance(direction);
        }
    }
    return sum;
}

Rgb LightSet::smoothBackground(const Vec3f& direction) const {
    Rgb sum(0.0f);
    for (std::size_t i : far_) {
        sum += isSmoothDome(i) ? lights_[i].dome.radiance(direction) : Rgb(0.0f);
    }
    return sum;
}

bool LightSet::hasDome() const {
    for (std::size_t i : far_) {
        if (lights_[i].type == Light::Type::Dome) {
            return true;
        }
    }
    return false;
}

// Distant lights whose disc is worth meeting.
bool LightSet::Prepared::seenAlong() const {
    static const float widest = float(std::cos(kMirroredDegrees * double(kPi) / 180));
    return type == Light::Type::Distant && cosAngle < widest;
}

template<class Visit>
void LightSet::along(const Way& w, Visit&& visit) const {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const auto meets = [&](const Prepared& l, float t) {
        return !l.behindThings() || !w.sampled ? t > w.tNear && (t < w.tMax || !(w.tMax < infinity)) : w.shadowless;
    };
    for (std::size_t i : far_) {
        const Prepared& l = lights_[i];
        if (!l.seenAlong() || !l.reaches(w.links) || !meets(l, infinity)) {
            continue;
        }
        const double cosine = std::min(double(l.cosAngle), std::cos(double(w.blur)));
        if (double(dot(w.direction, l.axis)) > cosine) {
            visit(l, l.emission / float(projectedSolidAngle(std::acos(std::clamp(cosine, -1.0, 1.0)))), infinity);
        }
    }
    tree_.along(w.origin, w.direction, w.sampled && w.shadowless && anyBehindThings_ ? infinity : w.tMax,
                [&](std::size_t i) {
                    const Prepared& l = lights_[i];
                    if (l.mesh || !l.reaches(w.links)) {
                        return;
                    }
                    const float t = l.shape.intersect(w.origin, w.direction);
                    if (t < infinity && meets(l, t)) {
                        visit(l, l.radiance(-w.direction, w.origin + w.direction * t), t);
                    }
                });
}

float LightSet::emitterDensity(std::uint32_t instance, float distance, float cosine) const {
    const auto it = emitters_.find(instance);
    if (it == emitters_.end()) {
        return 0;
    }
    const float solid = lights_[it->second].mesh->solidAngle(distance, cosine);
    return solid > 0 ? 1 / solid : std::numeric_limits<float>::infinity();
}

Rgb LightSet::mirrored(const Vec3f& origin, const Vec3f& direction, float tNear, float tMax, float blur,
                       std::uint64_t links) const {
    Rgb sum(0.0f);
    along({origin, direction, tNear, tMax, false, false, blur, links},
          [&](const Prepared&, const Rgb& radiance, float) { sum += radiance; });
    return sum;
}

Rgb LightSet::met(const Vec3f& origin, const Vec3f& direction, float tNear, float tMax, const Chosen& chosen) const {
    Rgb sum(0.0f);
    const auto add = [&](const Prepared& l, const Rgb& radiance, float sampled, float t) {
        const bool linked = l.shadows && l.shading != 0;
        const Rgb left = !linked ? Rgb(1.0f) : chosen.reach ? (*chosen.reach)(l.shading, t) : Rgb(0.0f);
        sum += radiance * left * (chosen.density / (chosen.density + sampled));
    };
    along({origin, direction, tNear, tMax, true, chosen.shadowless, 0, chosen.links},
          [&](const Prepared& l, const Rgb& radiance, float t) {
              float sampled = 0;
              if (l.type == Light::Type::Distant) {
                  sampled = distantDensity(l.cosAngle, dot(direction, l.axis));
              } else if (const float solid = l.shape.solidAngle(origin, direction, t); solid > 0) {
                  sampled = 1 / solid;
              }
              add(l, radiance, sampled, t);
          });
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const bool free = !(tMax < infinity);
    for (std::size_t i : far_) {
        const Prepared& l = lights_[i];
        if (l.type == Light::Type::Dome && l.reaches(chosen.links) && (l.behindThings() ? chosen.shadowless : free)) {
            add(l, l.dome.radiance(direction), float(chosen.domeSamples) * l.dome.density(chosen.normal, direction),
                infinity);
        }
    }
    return sum;
}

} // namespace stf
