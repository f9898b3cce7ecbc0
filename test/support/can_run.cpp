namespace talus::test
{
bool can_run()
{
#if defined(TALUS_GOLDEN_LEVEL)
  return __builtin_cpu_supports(TALUS_GOLDEN_LEVEL) != 0;
#else
  return true;
#endif
}
}  // namespace talus::test
