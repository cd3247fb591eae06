// The sand's shadow on the floor: leaves sky - coverage * strength of the floor's light. The project's colour space must
// be linear, because a shadow multiplies linear light.
Shader "Sandglass/Shadow" {
  SubShader {
    Tags { "RenderType" = "Transparent" "Queue" = "Transparent" }
    Pass {
      Blend SrcAlpha OneMinusSrcAlpha
      ZWrite Off
      Cull Off
      CGPROGRAM
      #pragma target 4.5
      #pragma vertex vertex
      #pragma fragment fragment
      #include "UnityCG.cginc"

      sampler2D _Coverage, _Sky;
      float4x4 _FromScene;
      float4 _Rectangle;  // low x, low z, high x, high z
      float _Strength;

      struct Corner { float4 position : SV_POSITION; float2 at : TEXCOORD0; };

      Corner vertex(uint index : SV_VertexID) {
        static const float2 corners[6] = { float2(0, 0), float2(1, 0), float2(1, 1), float2(0, 0), float2(1, 1), float2(0, 1) };
        Corner corner;
        corner.at = corners[index];
        float2 place = lerp(_Rectangle.xy, _Rectangle.zw, corner.at);
        float4 world = mul(_FromScene, float4(place.x, 0.001, -place.y, 1));  // right-handed to left-handed
        corner.position = mul(UNITY_MATRIX_P, mul(UNITY_MATRIX_V, world));
        return corner;
      }

      fixed4 fragment(Corner corner) : SV_Target {
        float left = tex2D(_Sky, corner.at).r - _Strength * tex2D(_Coverage, corner.at).r;
        return fixed4(0, 0, 0, 1 - max(left, 0));
      }
      ENDCG
    }
  }
}
