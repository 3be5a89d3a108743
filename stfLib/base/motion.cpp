// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/motion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stf {

namespace {

constexpr double kStepDegrees = 5;
constexpr int kMaxSteps = 128;      // Embree knows 129 time steps
constexpr int kStepsPerSegment = 4; // where samples lie between opening and closing: their times are rarely on a step

Transform blend(const Transform& a, const Transform& b, double t) {
    const double s = 1 - t;
    return {a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t, a.translation * s + b.translation * t};
}

/// Linear part as rotation (unit quaternion, real part first) times a symmetric stretch; mirrored maps have a negative
/// one.
struct Pose {
    std::array<double, 4> rotation{1, 0, 0, 0};
    Transform stretch;
    bool mirrored = false;
    bool valid = false;
};

std::array<double, 4> quaternionOf(const Transform& r) {
    const double trace = r.x.x + r.y.y + r.z.z;
    std::array<double, 4> q;
    if (trace > 0) {
        const double s = 2 * std::sqrt(trace + 1);
        q = {s / 4, (r.y.z - r.z.y) / s, (r.z.x - r.x.z) / s, (r.x.y - r.y.x) / s};
    } else if (r.x.x > r.y.y && r.x.x > r.z.z) {
        const double s = 2 * std::sqrt(1 + r.x.x - r.y.y - r.z.z);
        q = {(r.y.z - r.z.y) / s, s / 4, (r.y.x + r.x.y) / s, (r.z.x + r.x.z) / s};
    } else if (r.y.y > r.z.z) {
        const double s = 2 * std::sqrt(1 + r.y.y - r.x.x - r.z.z);
        q = {(r.z.x - r.x.z) / s, (r.y.x + r.x.y) / s, s / 4, (r.z.y + r.y.z) / s};
    } else {
        const double s = 2 * std::sqrt(1 + r.z.z - r.x.x - r.y.y);
        q = {(r.x.y - r.y.x) / s, (r.z.x + r.x.z) / s, (r.z.y + r.y.z) / s, s / 4};
    }
    const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& c : q) {
        c /= n;
    }
    return q;
}

Transform rotationOf(const std::array<double, 4>& q) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    Transform r;
    r.x = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
    r.y = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
    r.z = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
    return r;
}

/// Polar decomposition by Newton's iteration (Higham 1986).
Pose poseOf(const Transform& m) {
    Pose p;
    if (!m.invertible()) {
        return p;
    }
    Transform linear = m;
    linear.translation = Vec3d(0.0);
    Transform r = linear;
    for (int i = 0; i < 100; ++i) {
        const double d = r.determinant();
        const Transform inverseTranspose{cross(r.y, r.z) / d, cross(r.z, r.x) / d, cross(r.x, r.y) / d, Vec3d(0.0)};
        const Transform next = blend(r, inverseTranspose, 0.5);
        const double change = length(next.x - r.x) + length(next.y - r.y) + length(next.z - r.z);
        r = next;
        if (change < 1e-14) {
            break;
        }
    }
    p.mirrored = r.determinant() < 0;
    const Transform back{{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}, Vec3d(0.0)};
    p.stretch = compose(back, linear);
    if (p.mirrored) {
        for (Vec3d* column : {&r.x, &r.y, &r.z, &p.stretch.x, &p.stretch.y, &p.stretch.z}) {
            *column = -*column;
        }
    }
    p.rotation = quaternionOf(r);
    p.valid = isFinite(p.stretch.x) && std::isfinite(p.rotation[0]);
    return p;
}

/// From one sample to the next.
class Segment {
public:
    Segment(const TransformSample& a, const TransformSample& b) : a_(a), b_(b) {
        if (a.transform.x == b.transform.x && a.transform.y == b.transform.y && a.transform.z == b.transform.z) {
            return; // moved without turning
        }
        poseA_ = poseOf(a.transform);
        poseB_ = poseOf(b.transform);
        if (!poseA_.valid || !poseB_.valid || poseA_.mirrored != poseB_.mirrored) {
            return; // a singular place is passed, or a mirror: there is no rotation
        }
        double cosine = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            cosine += poseA_.rotation[i] * poseB_.rotation[i];
        }
        if (cosine < 0) { // the shorter way round
            cosine = -cosine;
            for (double& c : poseB_.rotation) {
                c = -c;
            }
        }
        halfAngle_ = std::acos(std::min(1.0, cosine));
        turns_ = halfAngle_ > 1e-9;
    }

    double degrees() const { return turns_ ? 2 * halfAngle_ * 180 / 3.14159265358979323846 : 0; }

    Transform at(double time) const {
        const double t = std::clamp((time - a_.time) / (b_.time - a_.time), 0.0, 1.0);
        Transform linear = blend(a_.transform, b_.transform, t);
        if (!turns_) {
            return linear;
        }
        std::array<double, 4> q;
        const double s = std::sin(halfAngle_), u = std::sin((1 - t) * halfAngle_) / s, v = std::sin(t * halfAngle_) / s;
        for (std::size_t i = 0; i < 4; ++i) {
            q[i] = u * poseA_.rotation[i] + v * poseB_.rotation[i];
        }
        Transform stretch = blend(poseA_.stretch, poseB_.stretch, t);
        stretch.translation = Vec3d(0.0);
        Transform turned = compose(rotationOf(q), stretch);
        turned.translation = linear.translation;
        return turned;
    }

    double end() const { return b_.time; }

private:
    TransformSample a_, b_;
    Pose poseA_, poseB_;
    double halfAngle_ = 0;
    bool turns_ = false;
};

} // namespace

std::vector<Transform> motionSteps(std::vector<TransformSample> samples, const Shutter& shutter) {
    samples.erase(
        std::remove_if(samples.begin(), samples.end(), [](const TransformSample& s) { return !std::isfinite(s.time); }),
        samples.end());
    std::stable_sort(samples.begin(), samples.end(),
                     [](const TransformSample& a, const TransformSample& b) { return a.time < b.time; });
    samples.erase(std::unique(samples.begin(), samples.end(),
                              [](const TransformSample& a, const TransformSample& b) { return a.time == b.time; }),
                  samples.end());
    const bool moves = std::any_of(samples.begin(), samples.end(), [&](const TransformSample& s) {
        return !(s.transform == samples.front().transform);
    });
    if (!shutter.blurs() || !moves) {
        return {};
    }
    std::vector<Segment> segments;
    double degrees = 0;
    int inside = 0;
    for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
        if (samples[i + 1].time <= shutter.open || samples[i].time >= shutter.close) {
            continue;
        }
        segments.emplace_back(samples[i], samples[i + 1]);
        const double share = (shutter.close - shutter.open) / (samples[i + 1].time - samples[i].time);
        degrees = std::max(degrees, segments.back().degrees() * share); // as if it went on like that all the time
        inside += samples[i].time > shutter.open || samples[i + 1].time < shutter.close ? 1 : 0;
    }
    if (segments.empty()) {
        return {};
    }
    const int steps =
        std::clamp(std::max(int(std::ceil(degrees / kStepDegrees - 1e-9)), kStepsPerSegment * inside), 1, kMaxSteps);
    std::vector<Transform> out;
    for (int i = 0; i <= steps; ++i) {
        const double time = shutter.open + (shutter.close - shutter.open) * i / steps;
        const auto holds = [time](const Segment& s) { return time <= s.end(); };
        const auto it = std::find_if(segments.begin(), segments.end(), holds);
        out.push_back((it == segments.end() ? segments.back() : *it).at(time));
    }
    const bool stays = std::all_of(out.begin(), out.end(), [&](const Transform& t) { return t == out.front(); });
    return stays ? std::vector<Transform>() : out;
}

Transform atTime(const std::vector<Transform>& steps, float time) {
    const double t = std::clamp(double(time), 0.0, 1.0) * double(steps.size() - 1);
    const std::size_t i = std::min(std::size_t(t), steps.size() > 1 ? steps.size() - 2 : 0);
    return steps.size() > 1 ? blend(steps[i], steps[i + 1], t - double(i)) : steps[0];
}

} // namespace stf
