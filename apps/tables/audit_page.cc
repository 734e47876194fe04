// The page of an audit: every case as one drawing a view.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/table.h"
#include "apps/report/encoding.h"
#include "apps/tables/audit.h"

namespace kinegraph {
namespace {

constexpr int kSize = 200;         // of a drawing, in its own units
constexpr double kLeastPx = 60.0;  // of the image that a drawing shows

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<style>
:root { --page: #f4f5f7; --card: #fff; --ink: #1b2430; --quiet: #5b6675;
  --line: #d5dae1; --estimate: #0072b2; --annotation: #d55e00;
  --seen: #1b2430; --held: #009e73; }
@media (prefers-color-scheme: dark) { :root { --page: #12161c; --card: #1b212a;
  --ink: #e7ebf0; --quiet: #9aa6b5; --line: #313a47; --estimate: #56b4e9;
  --annotation: #e69f00; --seen: #e7ebf0; --held: #4fd0a5; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1200px; padding: 12px 16px 40px;
  background: var(--page); color: var(--ink);
  font: 14px/1.45 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 20px; margin: 4px 0; } h2 { font-size: 17px; margin: 22px 0 6px; }
h3 { font-size: 14px; margin: 0 0 6px; }
p { max-width: 80ch; margin: 6px 0; color: var(--quiet); }
.case { background: var(--card); border: 1px solid var(--line);
  border-radius: 10px; padding: 10px 12px; margin: 10px 0; }
.views { display: flex; flex-wrap: wrap; gap: 10px; }
figure { margin: 0; width: 200px; }
figcaption { font-size: 12px; color: var(--quiet); }
figcaption b { color: var(--ink); }
svg { width: 200px; height: 200px; border: 1px solid var(--line);
  border-radius: 6px; display: block; }
.body { stroke: var(--quiet); stroke-width: 1.2; opacity: .55; fill: none; }
.seen { stroke: var(--seen); fill: var(--seen); stroke-width: 4; opacity: .8; }
.estimate { stroke: var(--estimate); fill: none; stroke-width: 2.5; }
.annotation { stroke: var(--annotation); fill: none; stroke-width: 2.5;
  stroke-dasharray: 7 4; }
.held { stroke: var(--held); fill: none; stroke-width: 1.6;
  stroke-dasharray: 2 3; }
.filters { display: flex; flex-wrap: wrap; gap: 4px 14px; margin: 10px 0; }
.legend svg { width: 34px; height: 10px; border: 0; display: inline-block; }
.legend span { margin-right: 16px; white-space: nowrap; }
[hidden] { display: none; }
</style>
)";

constexpr const char* kScript = R"(<script>
for (const box of document.querySelectorAll('input[data-verdict]')) {
  box.addEventListener('change', () => {
    for (const one of document.querySelectorAll('.case')) {
      if (one.dataset.verdict === box.dataset.verdict) one.hidden = !box.checked;
    }
  });
}
</script>
)";

using Pixel = std::optional<Eigen::Vector2d>;

// From the image to a drawing.
class Frame {
 public:
  void Include(const Pixel& px) {
    if (!px) return;
    low_ = low_.cwiseMin(*px);
    high_ = high_.cwiseMax(*px);
  }
  void Close() {
    const Eigen::Vector2d centre = 0.5 * (low_ + high_);
    const double extent = std::max(kLeastPx, 1.5 * (high_ - low_).maxCoeff());
    scale_ = kSize / extent;
    origin_ = centre - Eigen::Vector2d::Constant(0.5 * extent);
  }
  std::string At(const Eigen::Vector2d& px, const char* x,
                 const char* y) const {
    const Eigen::Vector2d at = (px - origin_) * scale_;
    return std::string(x) + "=\"" + Fixed(at.x(), 1) + "\" " + y + "=\"" +
           Fixed(at.y(), 1) + "\"";
  }
  bool empty() const { return !(low_.x() <= high_.x()); }

 private:
  Eigen::Vector2d low_ =
      Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_ = -low_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double scale_ = 1.0;
};

std::string Line(const Frame& frame, const Eigen::Vector2d& a,
                 const Eigen::Vector2d& b) {
  return "<line " + frame.At(a, "x1", "y1") + " " + frame.At(b, "x2", "y2") +
         "/>";
}

// A part: a line with a dot at each end that is there.
std::string Part(const Frame& frame, const Ends<Pixel>& ends, const char* style,
                 double radius) {
  std::string text = "<g class=\"" + std::string(style) + "\">";
  if (ends[0] && ends[1]) text += Line(frame, *ends[0], *ends[1]);
  for (const Pixel& end : ends) {
    if (!end) continue;
    text += "<circle " + frame.At(*end, "cx", "cy") + " r=\"" +
            Fixed(radius, 1) + "\"/>";
  }
  return text + "</g>";
}

const Detection* FindDetection(const DetectionSequence& detections,
                               int64_t frame, const ViewEvidence& view) {
  const DetectionFrame* at = FindDetectionFrame(detections, frame);
  if (at == nullptr) return nullptr;
  for (const Detection& one : at->views[view.view_idx].detections) {
    if (one.index_in_file == view.detection_idx) return &one;
  }
  return nullptr;
}

// The person as the view saw them, for the eye to find its way.
std::string Body(const Frame& frame, const DetectionSequence& detections,
                 int64_t number, const ViewEvidence& view) {
  const Detection* seen = FindDetection(detections, number, view);
  if (seen == nullptr) return "";
  std::string text = "<g class=\"body\">";
  for (const Bone& bone : detections.header.skeleton.bones()) {
    const Keypoint& a = seen->joints[bone.a];
    const Keypoint& b = seen->joints[bone.b];
    if (a.found && b.found) text += Line(frame, a.px, b.px);
  }
  return text + "</g>";
}

std::string Caption(const ViewEvidence& view, const std::string& name) {
  std::string text = "<b>" + HtmlText(name) + "</b>: " + ToString(view.verdict);
  if (view.verdict == ViewVerdict::kNoDetection) return text;
  text += "<br>confidence " + Fixed(view.confidence[0], 2) + ", " +
          Fixed(view.confidence[1], 2);
  if (!view.confident()) return text;
  text += "<br>estimate " + Fixed(view.estimate_mean_px, 1) +
          " px, annotation " + Fixed(view.annotation_mean_px, 1) + " px";
  if (view.held_out_mean_px) {
    text +=
        "<br>estimate without it " + Fixed(*view.held_out_mean_px, 1) + " px";
  }
  return text;
}

std::string Drawing(const AuditedBenchmark& audited, const AuditCase& one,
                    const ViewEvidence& view) {
  Frame frame;
  for (int end = 0; end < 2; ++end) {
    frame.Include(view.detected_px[end]);
    frame.Include(view.annotation_px[end]);
    frame.Include(view.estimate_px[end]);
  }
  std::string svg = "<svg viewBox=\"0 0 " + std::to_string(kSize) + " " +
                    std::to_string(kSize) + "\">";
  if (!frame.empty()) {
    frame.Close();
    svg += Body(frame, audited.detections, one.lost.frame, view) +
           Part(frame, view.detected_px, "seen", 4.0) +
           Part(frame, view.annotation_px, "annotation", 6.0) +
           Part(frame, view.estimate_px, "estimate", 5.0) +
           Part(frame, view.held_out_px, "held", 3.0);
  }
  return "<figure>" + svg + "</svg><figcaption>" +
         Caption(view, audited.view_names[view.view_idx]) +
         "</figcaption></figure>";
}

std::string Metres(const std::optional<double>& value) {
  return value ? Fixed(*value, 3) + " m" : "none";
}

std::string Case(const AuditedBenchmark& audited, const AuditCase& one) {
  std::string verdict = ToString(one.verdict);
  if (one.held_out_confirmed) verdict += ", held-out confirmed";
  if (one.refuted_by_views) verdict += ", refuted by the views alone";
  std::string text =
      "<section class=\"case\" data-verdict=\"" +
      std::string(ToString(one.verdict)) + "\"><h3>Frame " +
      std::to_string(one.lost.frame) + ", actor " +
      std::to_string(one.lost.actor) + ", " + PcpPartName(one.lost.part) +
      ": " + verdict + "</h3><p>Length " + Fixed(one.lost.length_m, 3) +
      " m; errors of the ends " + Metres(one.lost.first_error_m) + " and " +
      Metres(one.lost.second_error_m) + ".</p><div class=\"views\">";
  for (const ViewEvidence& view : one.views) {
    text += Drawing(audited, one, view);
  }
  return text + "</div></section>\n";
}

std::string LegendEntry(const char* style, const char* name) {
  return "<span><svg viewBox=\"0 0 34 10\"><g class=\"" + std::string(style) +
         "\"><line x1=\"0\" y1=\"5\" x2=\"34\" y2=\"5\"/></g></svg> " + name +
         "</span>";
}

}  // namespace

std::string AuditPage(const AuditedBenchmark& audited) {
  std::string page =
      std::string(kHead) + "<title>Annotation audit, " +
      HtmlText(audited.title) + "</title></head><body><h1>Annotation audit, " +
      HtmlText(audited.title) +
      "</h1><p>Witnesses: " + HtmlText(audited.detections_note) + ". " +
      HtmlText(audited.caution) +
      ".</p><p>Every limb that PCP counts wrong and whose ends a "
      "detector finds, in every view. Distances are means over "
      "the two ends.</p><p class=\"legend\">" +
      LegendEntry("seen", "detected") + LegendEntry("estimate", "estimate") +
      LegendEntry("annotation", "annotation") +
      LegendEntry("held", "estimate without this view") +
      LegendEntry("body", "the detected person") +
      "</p><div class=\"filters\">";
  for (const AuditVerdict verdict :
       {AuditVerdict::kContradicted, AuditVerdict::kEstimateWrong,
        AuditVerdict::kDisputed, AuditVerdict::kUndecided}) {
    page += "<label><input type=\"checkbox\" checked data-verdict=\"" +
            std::string(ToString(verdict)) + "\"> " + ToString(verdict) +
            "</label>";
  }
  page += "</div>\n";
  for (const AuditedEstimate& estimate : audited.estimates) {
    page += "<h2>" + HtmlText(estimate.method) + "</h2>\n";
    for (const AuditCase& one : estimate.audit.cases) {
      if (one.verdict != AuditVerdict::kNotAuditable) {
        page += Case(audited, one);
      }
    }
  }
  return page + kScript + "</body></html>\n";
}

}  // namespace kinegraph
