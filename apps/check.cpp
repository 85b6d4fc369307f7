// SPDX-License-Identifier: BSD-2-Clause
// `facet check`: in plain words, whether a recording can work and what is wrong.
#include "check.h"

#include <cstdio>
#include <memory>

#include "progress_bar.h"
#include <nlohmann/json.hpp>

#include "facet/check/check_recording.h"
#include "facet/io/errors.h"
#include "facet/io/json_file.h"
#include "facet/io/text_file.h"
#include "facet/recording/open_recording.h"

namespace facet {
namespace {

const char* WordOf(Sureness sureness) {
  return sureness == Sureness::kCertain ? "certain" : "likely";
}

/// Seconds since the first frame.
double SecondsOf(const CheckReport& report, Timestamp t) {
  return ToSeconds(t - report.first_frame);
}

void PrintFinding(const CheckReport& report, std::size_t number) {
  const Finding& finding = report.findings[number];
  std::printf("%zu. %s (%s): %s.\n",
              number + 1,
              finding.name.c_str(),
              WordOf(finding.sureness),
              finding.what.c_str());
  if (finding.when) {
    std::printf("   When: from %.2f to %.2f s.\n",
                SecondsOf(report, finding.when->from),
                SecondsOf(report, finding.when->to));
  }
  std::printf("   What to do: %s.\n", finding.advice.c_str());
}

void Print(const Recording& recording, const CheckReport& report) {
  std::printf("%s: %d frames in %.2f s, %d looked at; %d IMU samples\n",
              recording.name().c_str(),
              report.num_frames,
              report.duration_s,
              report.num_looked_at,
              report.num_imu);
  if (recording.calibration() != nullptr)
    std::printf("calibration: %s\n", recording.calibration()->source.c_str());
  for (std::size_t i = 0; i < report.findings.size(); ++i)
    PrintFinding(report, i);
  for (const Unchecked& unchecked : report.unchecked)
    std::printf("not checked: %s (%s)\n", unchecked.name.c_str(), unchecked.why.c_str());
  for (const std::string& figure : report.measured)
    std::printf("measured: %s\n", figure.c_str());
  for (const std::string& note : report.notes)
    std::printf("note: %s\n", note.c_str());
  if (report.findings.empty()) std::printf("nothing wrong was found\n");
}

std::string ToJson(const Recording& recording, const CheckReport& report) {
  nlohmann::ordered_json json;
  json["recording"] = recording.name();
  json["frames"] = report.num_frames;
  json["frames_looked_at"] = report.num_looked_at;
  json["imu_samples"] = report.num_imu;
  json["duration_s"] = report.duration_s;
  json["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : report.findings) {
    nlohmann::ordered_json item;
    item["name"] = finding.name;
    item["sureness"] = WordOf(finding.sureness);
    item["what"] = finding.what;
    if (finding.when) {
      item["from_s"] = SecondsOf(report, finding.when->from);
      item["to_s"] = SecondsOf(report, finding.when->to);
    }
    item["advice"] = finding.advice;
    json["findings"].push_back(item);
  }
  json["not_checked"] = nlohmann::ordered_json::array();
  for (const Unchecked& unchecked : report.unchecked)
    json["not_checked"].push_back({{"name", unchecked.name}, {"why", unchecked.why}});
  json["measured"] = report.measured;
  json["notes"] = report.notes;
  return JsonText(json, 2) + "\n";
}

}  // namespace

void CheckCommand(const CheckArguments& arguments) {
  RecordingOptions options;
  options.calibration = {arguments.calibration, arguments.imu_calibration};
  options.topics = ParseTopics(arguments.topics);
  options.needs_calibration = false;
  const std::unique_ptr<Recording> recording = OpenRecording(arguments.recording, options);
  ProgressBar bar(!arguments.quiet);
  const CheckReport report = CheckRecording(
      *recording, [&](int done, int total) { bar.Update(done, total, "stereo pairs"); });
  bar.Clear();
  Print(*recording, report);
  std::fflush(stdout);
  if (!arguments.json.empty()) ReplaceTextFile(arguments.json, ToJson(*recording, report));
  if (report.findings.empty()) return;
  throw InputError(arguments.recording + ": " + std::to_string(report.findings.size()) +
                   (report.findings.size() == 1 ? " thing is" : " things are") +
                   " wrong; what to do stands in the report");
}

}  // namespace facet
