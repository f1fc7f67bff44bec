#pragma once

namespace trefoil {

/// How the way from t = 0 to t = 1 is cut into load steps. Says when; who walks it says how it
/// went. In n equal steps nothing is tried again. Otherwise steps are halved until they succeed,
/// and doubled again after ones that were easy.
class StepSizes {
 public:
  /// n equal steps.
  static StepSizes equal(int count);
  /// @param first length of the first step, 0 to 1
  /// @param least length below which a step is not halved again
  static StepSizes adaptive(double first, double least);

  [[nodiscard]] bool is_done() const { return time_ >= 1; }
  /// Where the next step leads; 1 at the end, exactly.
  [[nodiscard]] double next() const;
  /// The step stands. @param was_easy whether a longer one may be tried
  void accept(bool was_easy);
  /// The step failed. @return whether a shorter one is left to be tried, which next() then says
  bool halve();
  [[nodiscard]] bool can_halve() const;  ///< whether halve() would say so

  /// Where the way has led so far.
  struct Reached {
    double time = 0, step = 0;  ///< step: length of the next one
    int accepted = 0;
    bool was_halved = false;  ///< since the last step that stands
  };
  [[nodiscard]] Reached reached() const { return {time_, step_, accepted_, was_halved_}; }
  void go_on(const Reached &reached);

  [[nodiscard]] double time() const { return time_; }  ///< where the last step led that stands
  [[nodiscard]] int accepted() const { return accepted_; }
  [[nodiscard]] bool is_adaptive() const { return count_ == 0; }
  [[nodiscard]] int count() const { return count_; }  ///< of equal steps; 0: adaptive

 private:
  StepSizes(int count, double first, double least) : count_(count), step_(first), least_(least) {}

  int count_;            ///< of equal steps; 0: adaptive
  double step_, least_;  ///< length of the next step, and of the shortest
  double time_ = 0;
  int accepted_ = 0;
  bool was_halved_ = false;  ///< since the last step that stands
};

}  // namespace trefoil
