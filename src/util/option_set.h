#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lsmvs {

// Closed interval that a number must lie in.
template <class T>
struct Range {
  T min = std::numeric_limits<T>::lowest();
  T max = std::numeric_limits<T>::max();
};

// Describes the fields of option structs: the one source of command-line flags, --help, ini keys,
// bound checks and of the text that a stage's options are hashed from. Holds pointers to the
// fields: it must not outlive the struct.
//
// A struct of options is plain data with defaults and has
//   void Describe(OptionSet* options);   // one Add a field, named "Group.field" as COLMAP would
//   bool Check(std::string* error) const { return CheckOptions(*this, error); }
class OptionSet {
 public:
  struct Entry {
    std::string name;           // "StereoFusion.min_num_pixels", or without a group
    std::string help;           // one sentence: meaning, unit, effect of raising it
    std::string type;           // "BOOL", "INT", "FLOAT", "TEXT" or "a|b|c"
    std::string bounds;         // "[0, 1]", or empty
    std::string default_value;  // as text; empty for an optional that is not set
    std::function<std::string()> get;
    // Throws UsageError that names option, value and what is allowed. Of a list it adds one value.
    std::function<void(const std::string&)> set;
    // Empty if the present value is within its bounds.
    std::function<std::string()> violation;
    // Of a list, which may be given several times, once for each value: empties it.
    std::function<void()> clear = {};
    bool is_rare = false;  // few users need it: --help gives its name alone

    bool is_list() const { return clear != nullptr; }
  };

  void Add(const std::string& name, bool* value, const std::string& help);
  void Add(const std::string& name, int* value, const std::string& help, Range<int> range = {});
  void Add(const std::string& name, double* value, const std::string& help,
           Range<double> range = {});
  void Add(const std::string& name, std::string* value, const std::string& help);
  void Add(const std::string& name, std::vector<std::string>* values, const std::string& help);
  // Texts in one value, separated by commas.
  void AddCommaList(const std::string& name, std::vector<std::string>* values,
                    const std::string& help);
  // A box as ParseBox() takes it.
  void Add(const std::string& name, Eigen::AlignedBox3d* box, const std::string& help);
  void Add(const std::string& name, std::optional<int>* value, const std::string& help,
           Range<int> range = {});
  void Add(const std::string& name, std::optional<double>* value, const std::string& help,
           Range<double> range = {});
  // Enumerations by their names.
  template <class Enum>
  void AddEnum(const std::string& name, Enum* value, const std::string& help,
               const std::vector<std::pair<std::string, Enum>>& choices) {
    std::vector<std::string> names;
    for (const auto& choice : choices) names.push_back(choice.first);
    AddChoice(
        name, help, names,
        [value, choices] {
          for (size_t i = 0; i < choices.size(); ++i) {
            if (choices[i].second == *value) return i;
          }
          return choices.size();
        },
        [value, choices](size_t i) { *value = choices[i].second; });
  }

  // Marks options, which must be there, as rare.
  void MarkRare(const std::vector<std::string>& names);

  const std::vector<Entry>& entries() const { return entries_; }
  // Null if there is none of that name.
  const Entry* Find(const std::string& name) const;
  // Checks every bound; the message names field, value and bound.
  bool Check(std::string* error) const;
  // "name=value" lines, in the order of description: what two runs compare to see if options
  // changed.
  std::string ToText() const;

 private:
  void AddChoice(const std::string& name, const std::string& help,
                 const std::vector<std::string>& choices, std::function<size_t()> get,
                 std::function<void(size_t)> set);
  void Push(Entry entry);

  std::vector<Entry> entries_;
};

// "xmin,ymin,zmin,xmax,ymax,zmax" (commas or blanks). Throws UsageError that names `option`. An
// empty text is an empty box.
Eigen::AlignedBox3d ParseBox(const std::string& option, const std::string& text);

// Check() of a struct that has Describe().
template <class Options>
bool CheckOptions(const Options& options, std::string* error) {
  Options copy = options;
  OptionSet set;
  copy.Describe(&set);
  return set.Check(error);
}

}  // namespace lsmvs
