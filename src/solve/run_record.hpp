#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace trefoil {

/// One solve, as the plugin recorded it.
struct AttemptRecord {
  std::string json;
  int load_step = 1;
  bool is_rejected = false;
};

/// The plugin's records of several solves, one after the other, as one in the form of each:
/// iterations, solves, trials, saddles and times added up, the histories in a row, whose entries
/// get the number of their step and whose linear solves go on (those of a solve that was rejected
/// are marked `rejected`); a list says the iterations of each step. Of a single solve it is its
/// record.
class RunRecord {
 public:
  /// @param step what a step is called: "load_step", "time_step"
  explicit RunRecord(std::string step) : step_(std::move(step)) {}

  /// @param record JSON, see TrefoilSNESGetRecord()
  /// @param number of the step, from 1; 0: of a softer body, whose energy is another
  /// @param is_rejected the solve failed, or its end was not taken
  void add(const std::string &record, int number, bool is_rejected);
  /// @param count whether what was reached in them was taken
  void add(const std::vector<AttemptRecord> &records, bool count);
  /// JSON; empty where nothing was added.
  [[nodiscard]] std::string text() const;

  using Json = nlohmann::ordered_json;
  /// What has been added, for a run that goes on later.
  [[nodiscard]] Json save() const;
  /// @param json of save(); what is missing there is an exception of nlohmann's
  void load(const Json &json);

 private:
  std::string step_;
  std::string only_;  ///< the record of the only solve
  int solves_ = 0;
  int last_number_ = -1;  ///< of the last step that was not rejected
  bool any_rejected_ = false;
  Json last_;  ///< the last solve's, with the sums of all
  Json history_ = Json::array(), iterations_ = Json::array();
};

}  // namespace trefoil
