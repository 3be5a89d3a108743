// SPDX-License-Identifier: Apache-2.0
// How fast camera rays find what they meet: the renderer's own ways beside a loop of nothing but Embree's queries, over
// the same triangles with the same rays. Prints a line of JSON.

#include "bench/bench_parts.h"
#include "bench/bench_view.h"
#include "stfLib/render/integrator.h"
#include "stfLib/render/renderer.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

using namespace stf;

namespace {

struct Arguments {
    std::string mesh;
    int size = 512, rounds = 5;
};

struct Pixel {
    int x, y;
};

const Vec3f kTowardsLight = normalize(Vec3f(0.5f, 0.7f, 1));

/// Triangles in an Embree scene, without instances or anything else between.
class BareScene {
public:
    /// `robust`: the flag of the renderer's own scenes, without which rays may slip between triangles.
    BareScene(const RefinedSurface& s, bool robust) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        if (robust) {
            rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        }
        RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* points = static_cast<Vec3f*>(
            rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), s.points.size()));
        auto* triangles = static_cast<Vec3i*>(
            rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Vec3i), s.triangles.size()));
        std::copy(s.points.begin(), s.points.end(), points);
        std::copy(s.triangles.begin(), s.triangles.end(), triangles);
        rtcCommitGeometry(g);
        rtcAttachGeometry(scene_, g);
        rtcReleaseGeometry(g);
        rtcCommitScene(scene_);
    }
    ~BareScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareScene(const BareScene&) = delete;
    BareScene& operator=(const BareScene&) = delete;

    /// How far the rays get, added up.
    float nearest(const std::vector<Ray>& rays) const {
        float sum = 0;
        for (const Ray& r : rays) {
            RTCRayHit h;
            h.ray = rayOf(r);
            h.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
            rtcIntersect1(scene_, &h);
#else
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcIntersect1(scene_, &context, &h);
#endif
            sum += h.hit.geomID == RTC_INVALID_GEOMETRY_ID ? 0.0f : h.ray.tfar;
        }
        return sum;
    }
    /// How many of them meet something.
    float any(const std::vector<Ray>& rays) const {
        int count = 0;
        for (const Ray& r : rays) {
            RTCRay h = rayOf(r);
#if RTC_VERSION_MAJOR >= 4
            rtcOccluded1(scene_, &h);
#else
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcOccluded1(scene_, &context, &h);
#endif
            count += h.tfar < 0;
        }
        return float(count);
    }

private:
    static RTCRay rayOf(const Ray& r) {
        RTCRay out;
        out.org_x = r.origin.x;
        out.org_y = r.origin.y;
        out.org_z = r.origin.z;
        out.tnear = r.tNear;
        out.dir_x = r.direction.x;
        out.dir_y = r.direction.y;
        out.dir_z = r.direction.z;
        out.time = 0;
        out.tfar = r.tFar;
        out.mask = ~0u;
        out.id = out.flags = 0;
        return out;
    }

    RTCDevice device_;
    RTCScene scene_;
};

/// Looks along -z at a box, which fills the picture's height.
Camera lookAt(const Box3f& box) {
    const Vec3d middle = (Vec3d(box.lo) + Vec3d(box.hi)) * 0.5;
    const double reach = 0.5 * double(box.diagonal()), distance = 3 * reach, opening = 0.3;
    const double low = distance - 1.5 * reach, high = distance + 1.5 * reach;
    Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -middle.x, -middle.y, -middle.z - distance, 1};
    return Camera(view, squareFrustum(opening, low, high));
}

/// The scene as the renderer prepares it, around the box's middle.
PreparedScene prepared(const std::shared_ptr<const RefinedSurface>& surface) {
    PreparedScene scene;
    scene.origin = (Vec3d(surface->bounds.lo) + Vec3d(surface->bounds.hi)) * 0.5;
    auto mesh = std::make_shared<PreparedMesh>();
    mesh->surface = surface;
    mesh->rayMesh = std::make_shared<const RayMesh>(surface->points, surface->triangles);
    PreparedInstance instance;
    instance.objectToWorld.translation = -scene.origin;
    instance.worldToObject = instance.objectToWorld.inverse();
    instance.mesh = mesh;
    RayInstance r;
    r.mesh = mesh->rayMesh;
    r.objectToWorld = instance.objectToWorld;
    scene.instances.push_back(instance);
    scene.rays = std::make_unique<const RayScene>(std::vector<RayInstance>{r});
    scene.shadowOffset = 1e-5f * surface->bounds.diagonal();
    return scene;
}

nlohmann::ordered_json run(const Arguments& a) {
    const ControlMesh control = meshOf(a.mesh);
    const auto surface = std::make_shared<const RefinedSurface>(refine(control, {}, {}));
    const PreparedScene scene = prepared(surface);
    const Camera camera = lookAt(surface->bounds);
    // Bare Embree gets the triangles where the instance puts them.
    RefinedSurface placed;
    placed.triangles = surface->triangles;
    for (const Vec3f& p : surface->points) {
        placed.points.push_back(Vec3f(Vec3d(p) - scene.origin));
    }
    const BareScene bare(placed, true), loose(placed, false);

    // In the order of the renderer: blocks of pixels in tiles.
    constexpr int tile = 16, block = 4;
    std::vector<Pixel> pixels;
    for (int i = 0; i < a.size * a.size; ++i) {
        const int t = i / (tile * tile), b = i / (block * block) % (tile / block * tile / block),
                  p = i % (block * block);
        pixels.push_back({t % (a.size / tile) * tile + b % (tile / block) * block + p % block,
                          t / (a.size / tile) * tile + b / (tile / block) * block + p / block});
    }
    const auto rayOf = [&](const Pixel& p) {
        return camera.ray(2 * (p.x + 0.5) / a.size - 1, 2 * (p.y + 0.5) / a.size - 1, scene.origin);
    };
    std::vector<Ray> rays, shadows;
    for (const Pixel& p : pixels) {
        rays.push_back(rayOf(p));
        RayHit hit;
        if (scene.rays->intersect(rays.back(), hit)) {
            const Surfel s = surfelAt(scene.instances[0], rays.back(), hit);
            const Vec3f normal = dot(s.normal, rays.back().direction) > 0 ? -s.normal : s.normal;
            if (dot(normal, kTowardsLight) > 0) {
                Ray shadow;
                shadow.origin = s.point + normal * scene.shadowOffset;
                shadow.direction = kTowardsLight;
                shadows.push_back(shadow);
            }
        }
    }

    Renderer renderer;
    RenderSettings settings;
    settings.threads = 1;
    settings.samples = 1 << 20;
    Scene whole;
    whole.setMesh("/mesh", control, 0);
    whole.setInstances("/mesh", {MeshInstance()});
    PreviewSurface white;
    white.diffuseColor = Rgb(1.0f);
    white.ior = 1.0f; // nothing glossy
    whole.setMaterial("/white", white);
    whole.setMeshMaterial("/mesh", "/white");
    whole.setLight("/sun", sunFrom(Vec3d(kTowardsLight), Rgb(1.0f)));
    settings.maxDepth = 0;
    renderer.setSettings(settings);
    renderer.setCamera(camera, a.size, a.size);
    Progress progress;
    renderer.prepare(whole, progress);
    renderer.renderPass(progress); // with AOVs, which further passes are without

    // Rates change while a machine warms up and others work: rounds go around all of the ways.
    const std::size_t n = rays.size(), both = n + shadows.size();
    double seconds[6];
    std::fill(std::begin(seconds), std::end(seconds), 1e300);
    std::uint64_t passRays = 0;
    for (int r = 0; r < a.rounds; ++r) {
        const auto time = [&](int way, const auto& f) { seconds[way] = std::min(seconds[way], processorSeconds(f)); };
        time(0, [&] { return bare.nearest(rays); });
        time(1, [&] { return loose.nearest(rays); });
        time(2, [&] {
            float sum = 0;
            for (const Ray& ray : rays) {
                RayHit hit;
                sum += scene.rays->intersect(ray, hit) ? hit.t : 0.0f;
            }
            return sum;
        });
        time(3, [&] {
            Integrator integrator(scene);
            float sum = 0;
            for (std::size_t p = 0; p < pixels.size(); p += kMostTogether) {
                Integrator::Bundle bundle;
                for (std::size_t i = p; i < std::min(pixels.size(), p + kMostTogether); ++i) {
                    bundle.time[bundle.count] = 0.5f;
                    bundle.ray[bundle.count++] = rayOf(pixels[i]);
                }
                integrator.meet(bundle);
                for (int i = 0; i < bundle.count; ++i) {
                    sum += integrator.firstHit(bundle, i, camera).cameraDepth;
                }
            }
            return sum;
        });
        time(4, [&] { return bare.nearest(rays) + bare.any(shadows); });
        const std::uint64_t before = renderer.stats().rays;
        time(5, [&] {
            renderer.renderPass(progress);
            return 0.0f;
        });
        passRays = renderer.stats().rays - before;
    }
    nlohmann::ordered_json j;
    j["triangles"] = surface->triangles.size();
    j["rays"] = n;
    j["shadowRays"] = shadows.size();
    j["bare"] = double(n) / seconds[0];
    j["bareNotRobust"] = double(n) / seconds[1];
    j["scene"] = double(n) / seconds[2];
    j["firstHit"] = double(n) / seconds[3];
    j["bareWithShadows"] = double(both) / seconds[4];
    j["picture"] = double(passRays) / seconds[5];
    j["pictureRays"] = passRays;
    j["sceneOfBare"] = seconds[0] / seconds[2];
    j["firstHitOfBare"] = seconds[0] / seconds[3];
    j["pictureOfBare"] = double(passRays) / double(both) * seconds[4] / seconds[5];
    return j;
}

} // namespace

int main(int argc, char** argv) {
    Arguments a;
    CLI::App app("Primary rays a second", "stf_bench_rays");
    app.add_option("mesh", a.mesh, "OBJ, PLY, STL or OFF")->required();
    app.add_option("--size", a.size, "Of the picture, pixels, a multiple of 16")->check(CLI::Range(16, 4096));
    app.add_option("--rounds", a.rounds, "The quickest counts")->check(CLI::Range(1, 1000));
    CLI11_PARSE(app, argc, argv);
    a.size = (a.size + 15) / 16 * 16;
    try {
        std::puts(run(a).dump().c_str());
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stf_bench_rays: %s\n", e.what());
        return 2;
    }
}
