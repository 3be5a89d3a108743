// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"
#include "stfLib/volume/base_volume.h"
#include "tools/stability/stability_case.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace stf {

/// A picture and what its renderer said.
struct SmallPicture {
    std::vector<float> color; ///< RGBA, rows from the bottom up
    std::vector<std::string> messages;
    std::vector<PlanEntry> plan;
    RenderStats stats;
    int tables = 0;        ///< asked for
    double tableError = 0; ///< of the last one, relative

    bool finite() const;
    float largest() const; ///< of all colours
    /// Mean colour, and the standard error of its green by the scatter of pixels (for pictures that should be even).
    Vec3d mean() const;
    double error() const;
    bool said(const std::string& part) const;
    /// The first entry of a stage; one that does not run and has no name where there is none.
    PlanEntry entry(const std::string& stage) const;
};

/// Largest difference of colours, relative to the largest colour of `b`.
double largestDifference(const SmallPicture& a, const SmallPicture& b);
/// Root mean square difference of colours, relative to the root mean square of `b`.
double rmsDifference(const SmallPicture& a, const SmallPicture& b);

/// A square of 20 by 20 mm around the origin with its normal along z.
ControlMesh squareMesh();
/// A closed cube of that edge (mm) around the origin.
ControlMesh cubeMesh(float edge, ControlMesh::Scheme scheme);

/// One object with a shell under lights, seen from above by a parallel camera: as small as shows what a case is about.
/// Members are changed, then it is rendered. Without changes: an isotropic, homogeneous shell of 2 mm on a square,
/// 1/mm, albedo .9, over black, under a distant light from the normal of irradiance pi.
struct SmallScene {
    explicit SmallScene(StabilityRun& stabilityRun);

    BaseVolume volume;
    std::string volumeFile; ///< empty: `volume` is written to one
    StfBinding binding;     ///< its file is filled in
    ControlMesh mesh = squareMesh();
    std::vector<MeshInstance> instances{MeshInstance()};
    std::map<std::string, ControlMesh> plain; ///< other objects, without a shell
    bool bound = true;                        ///< the object has a shell
    bool visible = true;
    std::map<std::string, Light> lights;
    double unitsPerMm = 1; ///< of the scene; camera and mesh go with it
    RenderSettings settings;
    int size = 8;          ///< of the picture, pixels
    double viewMm = 0.4;   ///< width of what is seen
    Vec3d lookAt{0, 0, 0}; ///< units
    double viewCosine = 1; ///< to z
    /// Camera of perspective there (units) instead, looking along -z (or z), 90 degrees wide.
    bool inside = false, upward = false;
    TableProvider tables; ///< empty: computed, each once per process

    Light& light() { return lights["/light"]; }
    /// Of the core: kappa 1/mm, isotropic.
    void setCore(double albedo);
    /// Towards the light: a cosine to z.
    void setLightCosine(double cosine);
    void setDome(float radiance);

    /// What the renderer is given.
    void fill(Scene& scene) const;
    Camera camera() const;
    SmallPicture render() const;
    /// The same by a renderer that is there already, after `prepare`; messages are its own affair.
    SmallPicture render(Renderer& renderer, const Scene& scene) const;

    StabilityRun& run;
};

/// A homogeneous volume of one column.
BaseVolume uniformVolume(double tau, double albedo, double g, int layers, double depthMm);

/// A renderer whose tables are computed once per process, counting how many it is asked for.
std::unique_ptr<Renderer> makeRenderer(int& asked, double& tableError, const TableProvider& tables = {});

} // namespace stf
