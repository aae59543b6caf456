#include "daemon/diagnosis_page.hpp"

#include <cmath>

#include "daemon/body_slices.hpp"
#include "daemon/body_view.hpp"
#include "daemon/diagnosis_figures.hpp"
#include "daemon/diagnosis_style.hpp"
#include "daemon/diagnosis_words.hpp"
#include "daemon/html.hpp"
#include "daemon/mismatch_field.hpp"
#include "daemon/page_style.hpp"
#include "daemon/text_table.hpp"
#include "daemon/version.hpp"

namespace tissued::daemon {
namespace {

// A heading with what belongs below it; nothing where there is nothing.
std::string section(const char* heading, const std::string& content) {
  return content.empty() ? content : element("section", element("h2", heading) + content);
}

std::string paragraph(const std::string& text, const char* attributes = "") {
  return text.empty() ? text : element("p", text, attributes);
}

std::string finding_words(const core::Diagnosis& diagnosis, const core::Scene& scene) {
  if (diagnosis.verdict == core::Verdict::no_mismatch) {
    return paragraph("What differs is no more than the noise of the measurement and the coarseness of the mesh.");
  }
  std::string html;
  for (const core::Finding& finding : diagnosis.findings) {
    html += paragraph(escape_html(finding.summary));
    html += paragraph(place_text(finding, scene) + " " + time_text(finding), "class=\"lead\"");
  }
  return html;
}

const char* verdict_class(core::Verdict verdict) {
  switch (verdict) {
    case core::Verdict::no_mismatch:
      return "good";
    case core::Verdict::unexplained:
      return "open";
    default:
      return "found";
  }
}

std::string verdict_section(const core::Diagnosis& diagnosis, const core::Scene& scene) {
  const std::string sure = sureness_text(diagnosis);
  const std::string said = element("p", verdict_text(diagnosis), "class=\"kicker\"") +
                           element("h1", headline(diagnosis) + ".") +
                           (sure.empty() ? "" : element("p", sure, "class=\"sure\"")) + finding_words(diagnosis, scene);
  return element("section", element("div", said, "class=\"said\"") + misfit_bars(diagnosis),
                 std::string("class=\"verdict ") + verdict_class(diagnosis.verdict) + "\"");
}

std::string unfinished_notice(const core::Diagnosis& diagnosis) {
  if (diagnosis.complete) return {};
  return element("div", "This diagnosis was stopped before its end: what it says is provisional.",
                 "class=\"notice\" role=\"note\"");
}

std::string place_section(const core::Diagnosis& diagnosis, const core::Scene& scene) {
  const std::vector<double> mismatch = mismatch_at_nodes(scene.mesh, diagnosis.mismatch_map);
  const std::string glow = mismatch.empty() ? "No place in the body stands out."
                                            : "The glow is where a change of the tissue would explain the misfit best.";
  std::string html =
      element("p", glow + " Drag the body to turn it, or click it and use the arrow keys, plus and minus.",
              "class=\"lead\"") +
      body_view(diagnosis, scene, mismatch);
  if (!mismatch.empty()) {
    core::Vec3 through = mismatch_peak(scene.mesh, mismatch);
    for (const core::Finding& finding : diagnosis.findings) {
      if (!finding.where || !finding.where->center.allFinite()) continue;
      through = finding.where->center;
      break;
    }
    html += element("h3", "Cuts through the place") + body_slices(diagnosis, scene, mismatch, through);
  }
  return section("Where", html);
}

std::string next_section(const core::Diagnosis& diagnosis) {
  return section("What to record next", paragraph(escape_html(diagnosis.next_experiment), "class=\"next\""));
}

std::string remark_section(const core::Diagnosis& diagnosis) {
  std::string items;
  for (const std::string& remark : diagnosis.remarks) items += element("li", escape_html(remark));
  return section("Remarks", items.empty() ? items : element("ul", items, "class=\"remarks\""));
}

std::string foot(const core::Diagnosis& diagnosis) {
  const std::string took = std::isfinite(diagnosis.seconds) ? ", in " + fixed(diagnosis.seconds, 0) + " s" : "";
  return element(
      "footer", element("p", "<b>Research software, not a medical device.</b> Nobody has tested it for clinical use.") +
                    element("p", "Written by <code>tissuectl diagnose</code> " + std::string(kVersion) + took + "."));
}

}  // namespace

std::string diagnosis_page(const core::Diagnosis& diagnosis, const core::Scene& scene) {
  const std::string name = escape_html(diagnosis.bundle);
  const std::string body =
      element("header", element("span", "Diagnosis of " + element("b", name)) + element("span", "tissued")) +
      unfinished_notice(diagnosis) + verdict_section(diagnosis, scene) + place_section(diagnosis, scene) +
      section("When", misfit_courses(diagnosis)) + section("Forces", force_courses(diagnosis)) +
      section("How well the simulation fits, before and after", misfit_table(diagnosis)) +
      section("How likely each explanation is", probability_bars(diagnosis)) +
      section("Numbers found", number_table(diagnosis)) + next_section(diagnosis) + remark_section(diagnosis) +
      foot(diagnosis);
  return "<!DOCTYPE html>\n<html lang=\"en\" class=\"diagnosis\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n" +
         element("title", "Diagnosis of " + name) + element("style", std::string(kPageStyle) + kDiagnosisStyle) +
         "</head>\n<body>\n" + element("main", body) + "</body>\n</html>\n";
}

}  // namespace tissued::daemon
